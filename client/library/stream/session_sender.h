// The sender of one session's scans, which lie in a spool. Private to the library.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "client/library/spool/session_spool.h"
#include "client/library/stream/reconnecting_sender.h"
#include "client/library/stream/scan_source.h"
#include "client/library/stream/scan_stream.h"
#include "client/library/stream/session_link.h"
#include "client/library/stream/token_bucket.h"
#include "core/concurrency/mutex.h"

namespace isthmus::client {

// Knows what was sent, what the server has, and what the robot was told; what is kept knows the
// spool. Over a spool on disk it tries for ever; else the scans end with this program, and it gives
// up after the client's BackoffOptions. Thread safe. Sequences are those of the spool but for what
// is sent, see SpoolIdentity::base.
class SessionSender final : private ScanSource {
 public:
  // The sender's owner. Called without locks held, from threads of the sender.
  struct Host {
    std::function<void(const ScanAck&)> acked;
    std::function<void(const std::string&)> event;
    std::function<void()> changed;               // There may be room, or it ended.
    std::function<void(SessionSender*)> behind;  // The link is back, and the backlog is old.
  };

  SessionSender(SessionLink* link, std::unique_ptr<SessionSpool> spool,
                const ScanStreamOptions& options, Host host);
  // Stops sending; what is left stays in the spool.
  ~SessionSender();

  // Begins to send.
  void Start();
  // As SessionSpool::Append.
  absl::Status Push(int64_t end_stamp_ns, std::string scan);
  // No more scans come. If `conclude`, the session is finished when the server has all, and its
  // spool removed; also if that is only asked for after the end. Not from a thread of the sender.
  void Close(bool conclude);

  // OK if the session can go on at a server that has it in the state `known`, without an id if the
  // server does not know it; the numbers of new scans follow that. FailedPrecondition, saying what
  // to do. Before Start.
  absl::Status Expect(const v1::Session& known);
  // False where the session was finished with more scans than are known here: which of those in the
  // spool it has cannot be told then.
  bool MayMoveOn(const v1::Session& known) const;

  SessionSpool& spool() { return *spool_; }
  const SpoolState& opened() const { return opened_; }
  SessionId session() const;
  ScanStreamStats stats() const;
  uint64_t backlog() const;  // Scans without acknowledgement.
  // New scans would wait behind older ones than SpoolOptions::prefer_live_after_s.
  bool behind() const;
  // Nothing once it has ended; then what became of it.
  std::optional<absl::Status> ended() const;
  // After Close(true) and an end without error.
  std::optional<v1::Session> finished() const;

 private:
  absl::StatusOr<OpenedSession> OpenSession(const Ask& ask) override;
  absl::StatusOr<bool> BeginLink(const v1::Session& known) override;
  Request NextRequest() override;
  Request InPlaceOf(const Request& too_large, uint64_t most_bytes) override;
  void InterruptLink() override;
  bool HandleResponse(const v1::StreamScansResponse& response) override;
  bool complete() const override;
  absl::Status ConcludeSession(const Ask& ask) override;
  void OnLinkLost() override;
  void Tell(const std::string& news) override;
  void OnEnd(const absl::Status& status) override;

  bool on_disk() const { return !options_.spool_dir.empty(); }
  // New scans are those that the server has behind the newest kept, where these were lost.
  bool is_replayed() const {
    return on_disk() && options_.spool.is_replayed && !spool_->identity().closed;
  }
  // Leaves in the spool that scans from `from` on may be others than the server's; 0: they are not.
  absl::Status MarkUnsure(uint64_t from);
  // FailedPrecondition, with the way out.
  absl::Status Gone(const std::string& why) const;
  // The same where a new session is no way out, see MayMoveOn.
  absl::Status FinishedBeyond(uint64_t last, uint64_t newest) const;
  // The newest scan that the server may have from here.
  uint64_t newest_known() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return std::max(mine_from_ - 1, sent_);
  }
  bool CanTell(const v1::Session& known) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The same where another attempt may know more.
  absl::Status Again(const std::string& why) const;
  absl::Status CheckKnown(const v1::Session& known) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Has the scans that are pushed from here follow those that the server has, whoever sent these.
  // Aborted, saying why, when they cannot.
  absl::Status FollowServer(uint64_t last) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status ChangeSession(const v1::Session& known, const absl::Status& why)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::vector<ScanAck> TakeUp(const v1::Session& known) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool TooFarBehind() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // The next to send, once it may be; nothing when there will be none on this link.
  std::optional<uint64_t> AwaitNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Request MakeRequest(uint64_t sequence);
  // Uses up the number, so that those behind it can follow; rejected for having no points.
  Request EmptyRequest(uint64_t sequence, int64_t stamp_ns) const;
  void TellNotes();

  SessionLink* const link_;
  const std::unique_ptr<SessionSpool> spool_;
  const ScanStreamOptions options_;
  const Host host_;
  const WaitClock& clock_;
  SpoolState opened_;

  mutable Mutex mutex_;
  CondVar changed_;
  // Lower sequences may have been sent by an earlier program.
  uint64_t mine_from_ ABSL_GUARDED_BY(mutex_);
  // The server has not told yet whether it has more scans than the spool of an earlier program.
  bool is_unsure_ ABSL_GUARDED_BY(mutex_) = false;
  // Scans up to here are not new: they only take their numbers again.
  uint64_t known_up_to_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t to_send_ ABSL_GUARDED_BY(mutex_) = 1;  // The next.
  uint64_t sent_ ABSL_GUARDED_BY(mutex_) = 0;     // The highest that this program has sent.
  uint64_t acked_ ABSL_GUARDED_BY(mutex_) = 0;    // All up to here are acknowledged.
  // All up to here took effect at the server, as far as is known.
  uint64_t at_server_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t lost_told_ ABSL_GUARDED_BY(mutex_) = 0;   // The highest that was reported as lost.
  uint64_t aside_told_ ABSL_GUARDED_BY(mutex_) = 0;  // The same for scans set aside.
  // Scans set aside, and lost, whose acknowledgement is to come.
  std::set<uint64_t> aside_ ABSL_GUARDED_BY(mutex_), lost_ ABSL_GUARDED_BY(mutex_);
  bool taken_up_ ABSL_GUARDED_BY(mutex_) = false;  // The server has told where the session stands.
  bool interrupted_ ABSL_GUARDED_BY(mutex_) = true;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
  bool conclude_ ABSL_GUARDED_BY(mutex_) = false;
  // The server has all, and was asked to finish the session.
  bool concluding_ ABSL_GUARDED_BY(mutex_) = false;
  bool over_ ABSL_GUARDED_BY(mutex_) = false;  // It has finished it.
  ScanStreamStats stats_ ABSL_GUARDED_BY(mutex_);
  TokenBucket bucket_ ABSL_GUARDED_BY(mutex_);
  std::optional<absl::Status> ended_ ABSL_GUARDED_BY(mutex_);
  std::optional<v1::Session> finished_ ABSL_GUARDED_BY(mutex_);

  std::unique_ptr<ReconnectingSender> sender_;  // Last, so that it goes first.
};

}  // namespace isthmus::client
