// A call that was let in: its caller, and its map.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/ids.h"
#include "server/access/caller.h"
#include "server/rpc/running_calls.h"
#include "server/rpc/site.h"
#include "server/rpc/streams/call_limits.h"

namespace isthmus::rpc {

// One per call, from the gate. Movable; must outlive neither the gate nor what its origin names.
// Destroying it waits for an OnEnd that is running.
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
  RunningCalls* running = nullptr;                // Its list; null: no token can end it.
  std::function<bool()> gone = nullptr;           // As CallOrigin has it.
  std::optional<CallLimits::Ticket> ticket = {};  // Its place among the calls of its kind.

  // For the event log.
  Actor actor() const { return {caller.token, peer, request_id}; }
  server::Pipeline& pipeline() const { return site->pipeline; }

  // True if the client is gone, or its deadline has passed: long work asks between two pieces.
  bool Gone() const { return gone(); }
  // Ok while the call may go on; Unauthenticated once its token is revoked or has expired. Cheap:
  // long calls ask between two messages.
  absl::Status Allowed() const { return admission->status(); }
  // For calls that wait: see Admission::SetOnEnd. A reactor finishes with the status given.
  void OnEnd(Admission::OnEnd on_end) const { admission->SetOnEnd(std::move(on_end)); }

  // PermissionDenied unless the caller may open sessions of that robot.
  absl::Status CheckRobot(const RobotId& robot) const;
  // True if the caller may be told of that session: a robot knows of its own alone.
  bool MayKnow(const SessionStatus& session) const;
  // The session, where the caller may know of it. NotFound where there is none, and in the same
  // words where it is another robot's: a robot cannot find out which others there are.
  absl::StatusOr<SessionStatus> OwnSession(const SessionId& session) const;
  // The same, but PermissionDenied also if the caller may know of it and not feed its robot.
  absl::StatusOr<SessionStatus> FedSession(const SessionId& session) const;
};

}  // namespace isthmus::rpc
