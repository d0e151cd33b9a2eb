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
  MemoryStream(std::shared_ptr<SessionLink> link, SessionId session, uint64_t last_sequence,
               const ScanStreamOptions& options);

  absl::Status Push(int64_t end_stamp_ns, PointPayload payload) override;
  absl::Status Finish() override;
  absl::StatusOr<SessionStatus> FinishSession() override;
  ScanStreamStats stats() const override;
  SpoolState resumed() const override { return {}; }
  SessionId session() const override { return session_; }

 private:
  absl::StatusOr<std::string> OpenSession(const Ask&) override { return session_.value(); }
  absl::Status BeginLink(const v1::Session& known) override;
  Request NextRequest() override;
  // Not asked for: the stream ends with the server's refusal, and its caller still has the scan.
  Request InPlaceOf(const Request&, uint64_t) override { return nullptr; }
  void InterruptLink() override;
  bool HandleResponse(const v1::StreamScansResponse& response) override;
  bool complete() const override;
  absl::Status ConcludeSession(const Ask&) override { return absl::OkStatus(); }
  void OnLinkLost(const absl::Status& why) override;
  void OnEnd(const absl::Status& status) override;
  void StartSender();

  const std::shared_ptr<SessionLink> link_;
  const SessionId session_;
  const ScanStreamOptions options_;

  mutable Mutex mutex_;
  CondVar changed_;
  ScanWindow<v1::StreamScansRequest> window_ ABSL_GUARDED_BY(mutex_);
  ScanStreamStats stats_ ABSL_GUARDED_BY(mutex_);
  std::deque<int64_t> stamps_ ABSL_GUARDED_BY(mutex_);  // Of the scans without acknowledgement.
  bool finishing_ ABSL_GUARDED_BY(mutex_) = false;      // No more scans will come.
  bool interrupted_ ABSL_GUARDED_BY(mutex_) = false;    // The current link has seen its end.
  bool done_ ABSL_GUARDED_BY(mutex_) = false;           // result_ is final.
  absl::Status result_ ABSL_GUARDED_BY(mutex_);

  Mutex concluding_ ABSL_ACQUIRED_BEFORE(mutex_);  // Held in FinishSession.
  std::optional<ReconnectingSender> sender_;       // Last: it ends before what it uses.
};

// Compressed if `options` ask for it. InvalidArgument when that cannot be done.
absl::StatusOr<PointPayload> Prepare(PointPayload payload, const ScanStreamOptions& options,
                                     int newest_version = kQuantizedVersion);
// The session after it was finished, with the client's patience; see FinishSessionRequest.
absl::StatusOr<SessionStatus> FinishAt(SessionLink& link, const SessionId& session,
                                       uint64_t last_sequence);

}  // namespace isthmus::client
