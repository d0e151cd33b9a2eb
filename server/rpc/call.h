// A call that was let in: who makes it, and which map it is about.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "core/concurrency/mutex.h"
#include "core/ids.h"
#include "server/access/caller.h"
#include "server/rpc/site.h"
#include "server/rpc/streams/call_limits.h"

namespace isthmus::rpc {

// What the gate and a call that it let in both hold: whether the call may go on. Thread safe.
class Admission {
 public:
  using OnEnd = std::function<void(const absl::Status&)>;

  // Ok, or why the call must end: its token was revoked, or has expired.
  absl::Status status() const;
  // The callback is called once, from a thread of the gate, when the call must end; at once, from
  // this thread, where that has happened already. It must not block.
  void SetOnEnd(OnEnd on_end);
  // No callback runs after this, nor while it returns, but where the callback itself calls it.
  void Forget();
  void End(const absl::Status& status);

 private:
  mutable Mutex mutex_;
  CondVar told_;
  absl::Status status_ ABSL_GUARDED_BY(mutex_);
  OnEnd on_end_ ABSL_GUARDED_BY(mutex_);
  std::thread::id telling_ ABSL_GUARDED_BY(mutex_);  // None: nobody is being told.
};

// One per call, from the gate. Movable; must not outlive the gate. Destroying it lets go of
// whatever the call held, and waits for an OnEnd that is running.
struct Call {
  Call() = default;
  Call(Call&&) = default;
  Call& operator=(Call&&) = delete;
  ~Call();

  std::string rpc = {};         // "CreateSession"; unique among all services.
  access::Caller caller = {};   // Role, robots that it may feed, the name of its token.
  Site* site = nullptr;         // Never null in a call that was let in.
  std::string peer = {};        // As gRPC names it: "ipv4:127.0.0.1:4711".
  std::string request_id = {};  // The client's, else one of ours; for logs.
  std::shared_ptr<Admission> admission = {};
  const grpc::ServerContextBase* context = nullptr;  // Outlives the call.
  std::optional<CallLimits::Ticket> ticket = {};     // Its place among the calls of its kind.

  server::Pipeline& pipeline() const { return site->pipeline; }

  // Whether the client is gone, or its deadline has passed: long work asks between two pieces.
  bool Gone() const { return context != nullptr && context->IsCancelled(); }
  // Ok while the call may go on; Unauthenticated once its token is revoked or has expired. Cheap:
  // long calls ask between two messages.
  absl::Status Allowed() const { return admission->status(); }
  // For calls that wait: see Admission::SetOnEnd. A reactor finishes with the status given.
  void OnEnd(Admission::OnEnd on_end) const { admission->SetOnEnd(std::move(on_end)); }

  // PermissionDenied unless the caller may open sessions of that robot.
  absl::Status CheckRobot(const RobotId& robot) const;
  // The session, where the caller may know of it. NotFound where there is none, and in the same
  // words where it is another robot's: a robot cannot find out which others there are.
  absl::StatusOr<SessionStatus> OwnSession(const SessionId& session) const;
};

}  // namespace isthmus::rpc
