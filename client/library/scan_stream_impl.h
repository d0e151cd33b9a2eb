// The machinery of a scan stream. Private to the library.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "client/library/link.h"
#include "client/library/scan_stream.h"
#include "client/library/scan_window.h"

namespace isthmus::client {

// Three kinds of threads meet here: the robot's (Push, Finish), the writer, which opens links and
// sends, and per link a reader, which takes acknowledgements. All of them hold mutex_ while they
// touch the window, none while it waits for the network.
class ScanStream::Impl {
 public:
  Impl(std::shared_ptr<Client::Link> link, SessionId session, uint64_t last_sequence,
       const ScanStreamOptions& options);
  ~Impl();

  absl::Status Push(int64_t end_stamp_ns, PointPayload payload);
  absl::Status Finish();
  ScanStreamStats stats() const;

 private:
  using Wire = grpc::ClientReaderWriter<v1::StreamScansRequest, v1::StreamScansResponse>;

  void WriteLoop();
  // From opening a link to its end. OK only when everything was acknowledged after Finish.
  absl::Status RunLink();
  // Sends what the window holds until all is done or the link breaks.
  void SendOn(Wire& wire);
  // The next scan to send; waits for one. Null when there will be none on this link.
  std::shared_ptr<const v1::StreamScansRequest> NextToSend();
  void ReadFrom(Wire& wire);
  void TakeAck(const v1::StreamScansResponse& response);
  // Waits, or is woken by the destructor.
  void WaitBeforeRetry(double seconds);

  const std::shared_ptr<Client::Link> link_;
  const SessionId session_;
  const ScanStreamOptions options_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // Guarded by mutex_ from here.
  ScanWindow<v1::StreamScansRequest> window_;
  ScanStreamStats stats_;
  std::deque<int64_t> stamps_;  // Of the scans without acknowledgement.
  bool finishing_ = false;      // No more scans will come.
  bool abandoned_ = false;      // By the destructor.
  bool link_broken_ = false;    // The reader of the current link has seen its end.
  bool progress_ = false;       // An acknowledgement came since the last failure.
  bool done_ = false;           // result_ is final.
  absl::Status result_;
  grpc::ClientContext* context_ = nullptr;  // Of the current link, to cancel it.

  std::thread writer_;  // Last, so that it starts when everything else is there.
};

}  // namespace isthmus::client
