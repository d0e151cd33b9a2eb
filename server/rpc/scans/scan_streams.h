// The registry of streams and the sessions they feed: at most one each, the newest.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <functional>
#include <map>
#include <memory>

#include "core/concurrency/mutex.h"
#include "core/ids.h"
#include "server/rpc/scans/ack_window.h"
#include "server/sessions.h"

namespace isthmus::rpc {

// Thread safe.
class ScanStreams {
 public:
  // A place in the registry; gives it up when destroyed.
  class Registration {
   public:
    ~Registration();
    Registration(const Registration&) = delete;
    Registration& operator=(const Registration&) = delete;

    const SessionId& session() const { return session_; }
    AckWindow& window() { return *window_; }

   private:
    friend class ScanStreams;
    Registration(ScanStreams& streams, SessionId session, const AckWindow::Limits& limits,
                 std::function<void()> on_change)
        : streams_(streams),
          session_(std::move(session)),
          window_(std::make_shared<AckWindow>(limits, std::move(on_change))) {}

    ScanStreams& streams_;
    const SessionId session_;
    const std::shared_ptr<AckWindow> window_;  // Shared with the sink the pipeline holds.
  };

  // A stream may have so many scans without a written acknowledgement.
  ScanStreams(server::Sessions& sessions, const AckWindow::Limits& window)
      : sessions_(sessions), window_(window) {}

  // Makes the caller the session's stream; the window of an earlier one is closed. `on_change` is
  // that of its window, which may outlive the registration. Errors of Sessions::SetAckSink.
  absl::StatusOr<std::unique_ptr<Registration>> Register(const SessionId& session,
                                                         std::function<void()> on_change);
  // Closes the window of the session's stream, if there is one.
  void Drop(const SessionId& session);

 private:
  void Unregister(Registration* registration);

  server::Sessions& sessions_;
  const AckWindow::Limits window_;
  Mutex mutex_;
  std::map<SessionId, Registration*> current_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::rpc
