#include "server/rpc/call.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

namespace isthmus::rpc {

Call::~Call() {
  if (admission == nullptr) return;  // Moved away.
  if (running != nullptr) running->Leave(admission);
  admission->Forget();
}

absl::Status Call::CheckRobot(const RobotId& robot) const {
  if (caller.MayFeed(robot)) return absl::OkStatus();
  return absl::PermissionDeniedError(
      absl::StrCat("the token \"", caller.token,
                   "\" is for robots of these names: ", absl::StrJoin(caller.robots, ", "),
                   "; use the robot's own token, or have an administrator make one for it"));
}

bool Call::MayKnow(const SessionStatus& session) const {
  // A caller that may read the map sees all sessions there.
  return caller.role != access::Role::kRobot || caller.MayFeed(session.record.robot);
}

absl::StatusOr<SessionStatus> Call::OwnSession(const SessionId& session) const {
  auto status = pipeline().sessions().Get(session);
  const bool is_robot = caller.role == access::Role::kRobot;
  if (status.ok() ? MayKnow(*status) : !is_robot || !absl::IsNotFound(status.status())) {
    return status;
  }
  // In the same words for one that is another's and one that is not there.
  return absl::NotFoundError(
      absl::StrCat("no session \"", session.value(), "\" of the robots that this token is for"));
}

absl::StatusOr<SessionStatus> Call::FedSession(const SessionId& session) const {
  auto status = OwnSession(session);
  if (!status.ok()) return status;
  const absl::Status own = CheckRobot(status->record.robot);
  return own.ok() ? status : own;
}

}  // namespace isthmus::rpc
