// The way of scans to the server, over as many links as it takes. Private to the library.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <thread>

#include "client/library/stream/backoff.h"
#include "client/library/stream/outage.h"
#include "client/library/stream/scan_source.h"
#include "client/library/stream/session_link.h"
#include "core/concurrency/mutex.h"

namespace isthmus::client {

struct ReconnectingSenderOptions {
  bool for_ever = false;  // Else until backoff.max_attempts fail in a row.
  BackoffOptions backoff = {};
  double first_deadline_s = 0;  // For a link's first question; 0: call_timeout_s.
  double stall_timeout_s = 0;   // A link without progress for so long is opened anew; 0: never.
};

// Its threads: the writer, which opens links and sends; per link a reader, which takes
// acknowledgements, and a watchman. None of them holds mutex_ while it waits for the network.
class ReconnectingSender {
 public:
  // Both must outlive it.
  ReconnectingSender(SessionLink* link, ScanSource* source,
                     const ReconnectingSenderOptions& options);
  ~ReconnectingSender();  // Gives up.
  // As the destructor will, but does not wait.
  void Abandon();

 private:
  void WriteLoop();
  bool WorthAnotherTry(const absl::Status& status) const;
  // From opening a link to its end. OK only when everything was acknowledged and concluded.
  absl::Status RunLink();
  absl::Status StreamScans(const v1::Session& session);
  // A session that was refused though it was there a moment before: a lost link, once, as the next
  // one asks what became of it.
  absl::Status Refused(const absl::Status& status);
  absl::Status AskServer(ScanSource::Duration duration, const ScanSource::Attempt& attempt);
  // The next to send, of a size that the server takes as far as is known. Null when there will be
  // none on this link.
  ScanSource::Request NextThatFits(const v1::Session& session);
  void SendOn(ScanWire& wire, const v1::Session& session);
  void ReadFrom(ScanWire& wire);
  void WatchProgress();
  void WaitBeforeRetry(double seconds);
  void TellUnlessEmpty(const std::string& news);

  SessionLink* const link_;
  ScanSource* const source_;
  const ReconnectingSenderOptions options_;
  const WaitClock& clock_;
  const double longest_s_, first_s_;  // Deadlines of questions.

  bool was_refused_ = false;  // Without progress since. Used by the thread that writes.
  Outage outage_;  // Used by the thread that reads while there is one, else by the one that writes.

  Mutex mutex_;
  CondVar changed_;
  bool abandoned_ ABSL_GUARDED_BY(mutex_) = false;
  // Most bytes that the server said it takes, on the link before; 0: it said none. A later one may
  // take more.
  uint64_t most_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  bool streamed_ ABSL_GUARDED_BY(mutex_) = false;  // A stream was opened since the last failure.
  bool progress_ ABSL_GUARDED_BY(mutex_) =
      false;                                   // An acknowledgement came since the last failure.
  double deadline_s_ ABSL_GUARDED_BY(mutex_);  // For the next question.
  SessionCall* call_ ABSL_GUARDED_BY(mutex_) = nullptr;  // Under way, to be cancelled.
  // The current link:
  bool over_ ABSL_GUARDED_BY(mutex_) = false;
  bool stalled_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  double moved_s_ ABSL_GUARDED_BY(mutex_) = 0;  // When something was last written or read.
  std::deque<size_t> unanswered_
      ABSL_GUARDED_BY(mutex_);  // Sizes of the scans sent without acknowledgement.

  std::thread writer_;  // Last, so that it starts when everything else is there.
};

}  // namespace isthmus::client
