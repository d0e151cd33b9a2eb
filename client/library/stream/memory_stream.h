// A stream that keeps its scans in memory. Private to the library.
#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "client/library/stream/reconnecting_sender.h"
#include "client/library/stream/scan_source.h"
#include "client/library/stream/scan_stream_impl.h"
#include "client/library/stream/scan_window.h"
#include "client/library/stream/session_link.h"
#include "core/concurrency/mutex.h"

namespace isthmus::client {

// Thread safe: the robot's thread and the sender's meet here.
class MemoryStream final : public ScanStream::Impl, private ScanSource {
 public:
  // `session` as the server has just told.
  MemoryStream(std::shared_ptr<SessionLink> link, const v1::Session& session,
               const ScanStreamOptions& options);

  absl::Status Push(int64_t end_stamp_ns, PointPayload payload) override;
  absl::Status Finish() override;
  absl::StatusOr<SessionStatus> FinishSession() override;
  void GiveUp() override;
  ScanStreamStats stats() const override;
  SpoolState resumed() const override { return {}; }
  std::optional<bool> IsNewest(int64_t, PointPayload) const override { return std::nullopt; }
  SessionId session() const override { return session_; }

 private:
  absl::StatusOr<OpenedSession> OpenSession(const Ask&) override {
    return OpenedSession{session_.value(), created_ns_};
  }
  absl::Status BeginLink(const v1::Session& known) override;
  Request NextRequest() override;
  // Not asked for: the stream ends with the server's refusal, and its caller still has the scan.
  Request InPlaceOf(const Request&, uint64_t) override { return nullptr; }
  void InterruptLink() override;
  bool HandleResponse(const v1::StreamScansResponse& response) override;
  bool complete() const override;
  absl::Status ConcludeSession(const Ask& ask) override;
  void OnLinkLost() override;
  void Tell(const std::string& news) override;
  void OnEnd(const absl::Status& status) override;
  void StartSender();
  absl::Status AwaitEnd() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::shared_ptr<SessionLink> link_;
  const SessionId session_;
  const int64_t created_ns_;
  const ScanStreamOptions options_;

  mutable Mutex mutex_;
  CondVar changed_;
  ScanWindow<v1::StreamScansRequest> window_ ABSL_GUARDED_BY(mutex_);
  ScanStreamStats stats_ ABSL_GUARDED_BY(mutex_);
  std::deque<int64_t> stamps_ ABSL_GUARDED_BY(mutex_);  // Scans without acknowledgement.
  bool finishing_ ABSL_GUARDED_BY(mutex_) = false;      // No more scans will come.
  bool interrupted_ ABSL_GUARDED_BY(mutex_) = false;    // The current link has seen its end.
  bool conclude_ ABSL_GUARDED_BY(mutex_) = false;       // The session is to be finished, too.
  std::optional<v1::Session> finished_ ABSL_GUARDED_BY(mutex_);
  bool done_ ABSL_GUARDED_BY(mutex_) = false;  // The sender has ended, with result_.
  absl::Status result_ ABSL_GUARDED_BY(mutex_);

  Mutex concluding_ ABSL_ACQUIRED_BEFORE(mutex_);  // Held in FinishSession.
  std::optional<ReconnectingSender> sender_;       // Last: it ends before what it uses.
};

// Compressed if `options` ask for it. InvalidArgument when that cannot be done.
absl::StatusOr<PointPayload> Prepare(PointPayload payload, const ScanStreamOptions& options,
                                     int newest_version = kQuantizedVersion);

}  // namespace isthmus::client
