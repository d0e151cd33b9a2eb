#include "client/console/submap_sender.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

#include <utility>

#include "core/io/sha256.h"

namespace isthmus::cli {
namespace {

constexpr size_t kNameCharacters = 40;  // Format: of a request's id, of which there are 64 at most.

// The same for the same upload begun again: its first submap is the same.
std::string RequestIdOf(const SubmapUpload& first) {
  std::string content = io::Sha256(first.cloud.data.data(), first.cloud.data.size());
  if (content.empty()) return "";
  const auto add = [&content](const StampedPose& at) {
    content.append(reinterpret_cast<const char*>(&at.stamp_ns), sizeof(at.stamp_ns));
    content.append(reinterpret_cast<const char*>(at.pose.translation().data()), 3 * sizeof(double));
    content.append(reinterpret_cast<const char*>(at.pose.rotation().coeffs().data()),
                   4 * sizeof(double));
  };
  add({first.last_stamp_ns, first.T_odom_submap});
  for (const StampedPose& keyframe : first.keyframes) add(keyframe);
  const std::string hex = absl::BytesToHexString(io::Sha256(content.data(), content.size()));
  return absl::StrCat("upload-", hex.substr(0, kNameCharacters));
}

bool IsSame(const SubmapInfo& stored, const SubmapUpload& submap) {
  return stored.point_count == submap.cloud.width &&
         stored.keyframe_count == submap.keyframes.size() &&
         stored.first_stamp_ns == submap.first_stamp_ns &&
         stored.last_stamp_ns == submap.last_stamp_ns &&
         stored.T_odom_submap.Matrix().isApprox(submap.T_odom_submap.Matrix(), 1e-6);
}

}  // namespace

SubmapSender::SubmapSender(client::Client& client, SubmapTarget target)
    : client_(client), target_(std::move(target)) {}

absl::Status SubmapSender::Send(SubmapUpload submap) {
  if (session_.empty()) {
    if (absl::Status status = Open(submap); !status.ok()) return status;
  }
  submap.id.session = session_;
  const auto known = known_.find(submap.id.index);
  if (known != known_.end() && !IsSame(known->second, submap)) {
    return absl::AlreadyExistsError(
        absl::StrCat("submap ", ToString(submap.id),
                     " is stored with other content: clouds, poses or options have changed since; "
                     "upload as another robot, or delete the session"));
  }
  // A submap that is missing below the newest was replaced by newer ones of the same ground.
  const bool is_there = !known_.empty() && submap.id.index <= known_.rbegin()->first;
  if (!is_there && was_finished_) {
    return absl::AlreadyExistsError(
        absl::StrCat("session ", session_.value(), " is finished and has no submap ",
                     submap.id.index, ": upload as another robot, or delete the session"));
  }
  if (!is_there) {
    const absl::Status status = client_.UploadSubmap(submap);
    if (absl::IsFailedPrecondition(status)) {
      return absl::FailedPreconditionError(absl::StrCat(
          status.message(), "; did another upload of the same clouds end before this one?"));
    }
    if (!status.ok()) return status;
    sent_bytes_ += submap.cloud.data.size();
  }
  before_ += is_there ? 1 : 0;
  ++submaps_;
  return absl::OkStatus();
}

absl::Status SubmapSender::Finish() {
  if (session_.empty() || was_finished_) return absl::OkStatus();
  return client_.FinishSession(session_).status();
}

absl::Status SubmapSender::Open(const SubmapUpload& first) {
  SessionRequest request = target_.request;
  request.request_id = RequestIdOf(first);
  const auto session = target_.session.empty() ? client_.CreateSession(std::move(request))
                                               : client_.GetSession(SessionId(target_.session));
  if (!session.ok()) return session.status();
  if (session->record.robot != target_.request.robot) {
    return absl::InvalidArgumentError(absl::StrCat("session ", target_.session, " is robot ",
                                                   session->record.robot.value(), "'s, not ",
                                                   target_.request.robot.value(), "'s"));
  }
  const auto submaps = client_.ListSubmaps(session->record.robot);
  if (!submaps.ok()) return submaps.status();
  for (const SubmapStatus& submap : *submaps) {
    if (submap.info.id.session != session->record.id) continue;
    known_[submap.info.id.index] = submap.info;
  }
  session_ = session->record.id;
  was_finished_ = session->record.state == SessionState::kFinished;
  return absl::OkStatus();
}

}  // namespace isthmus::cli
