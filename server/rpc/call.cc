#include "server/rpc/call.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <utility>

namespace isthmus::rpc {

absl::Status Admission::status() const {
  MutexLock lock(&mutex_);
  return status_;
}

void Admission::SetOnEnd(OnEnd on_end) {
  absl::Status ended;
  {
    MutexLock lock(&mutex_);
    if (status_.ok()) {
      on_end_ = std::move(on_end);
      return;
    }
    ended = status_;
  }
  on_end(ended);
}

void Admission::Forget() {
  MutexLock lock(&mutex_);
  on_end_ = nullptr;
  // A callback that ends its own call would wait for itself.
  while (telling_ != std::thread::id() && telling_ != std::this_thread::get_id()) {
    told_.Wait(&mutex_);
  }
}

void Admission::End(const absl::Status& status) {
  OnEnd on_end;
  {
    MutexLock lock(&mutex_);
    if (!status_.ok()) return;
    status_ = status;
    on_end = std::exchange(on_end_, nullptr);
    if (on_end == nullptr) return;
    telling_ = std::this_thread::get_id();
  }
  on_end(status);
  MutexLock lock(&mutex_);
  telling_ = std::thread::id();
  told_.SignalAll();
}

Call::~Call() {
  if (admission != nullptr) admission->Forget();
}

absl::Status Call::CheckRobot(const RobotId& robot) const {
  if (caller.MayFeed(robot)) return absl::OkStatus();
  return absl::PermissionDeniedError(
      absl::StrCat("the token \"", caller.token,
                   "\" is for robots of these names: ", absl::StrJoin(caller.robots, ", "),
                   "; use the robot's own token, or have an administrator make one for it"));
}

absl::StatusOr<SessionStatus> Call::OwnSession(const SessionId& session) const {
  auto status = pipeline().GetSession(session);
  // Whoever may read the map sees all sessions there.
  if (caller.role != access::Role::kRobot) return status;
  if (status.ok() && caller.MayFeed(status->record.robot)) return status;
  if (!status.ok() && !absl::IsNotFound(status.status())) return status.status();
  return absl::NotFoundError(
      absl::StrCat("no session \"", session.value(), "\" of the robots that this token is for"));
}

}  // namespace isthmus::rpc
