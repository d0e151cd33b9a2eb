// What a pose graph is made of beside matches: loop closures and anchors.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/note.h"
#include "server/pipeline/pipeline_impl.h"

namespace isthmus::server {
namespace {

absl::Status CheckAnchor(const Anchor& anchor) {
  const double sigmas[] = {anchor.sigma_xy_m, anchor.sigma_z_m, anchor.sigma_deg};
  const bool usable = std::all_of(std::begin(sigmas), std::end(sigmas),
                                  [](double sigma) { return std::isfinite(sigma) && sigma >= 0; });
  if (!usable || *std::max_element(std::begin(sigmas), std::end(sigmas)) == 0) {
    return absl::InvalidArgumentError(
        "an anchor's standard deviations are finite and not negative, and one of them is positive: "
        "0 says that this part of the pose is not known");
  }
  if (!anchor.T_map_submap.IsFinite()) {
    return absl::InvalidArgumentError("the anchor's pose has numbers that are not finite");
  }
  if (anchor.T_map_submap.translation().cwiseAbs().maxCoeff() > kMaxAnchorM) {
    return absl::InvalidArgumentError(
        absl::StrCat("the anchor is more than ", kMaxAnchorM / 1000,
                     " km from the origin: give coordinates relative to a point of the site"));
  }
  return CheckNote(anchor.note);
}

}  // namespace

int64_t PipelineImpl::RevisionOncePlaced() {
  state_.WaitUntilPlaced();
  std::lock_guard lock(state_.mutex);
  return state_.revision.revision;
}

LoopStatus PipelineImpl::StatusOf(const LoopClosure& loop) const {
  LoopStatus status{loop};
  const auto it = state_.judgement.loops.find(loop.id);
  if (it == state_.judgement.loops.end() || loop.rejected) return status;
  status.edges_used = static_cast<uint32_t>(std::count(it->second.begin(), it->second.end(), true));
  return status;
}

absl::StatusOr<std::vector<LoopStatus>> PipelineImpl::ListLoops(
    const std::optional<RobotId>& robot) {
  std::lock_guard lock(state_.mutex);
  if (robot && state_.Newest(*robot) == nullptr) {
    return absl::NotFoundError(
        absl::StrCat("no robot \"", robot->value(), "\" has opened a session on this server"));
  }
  std::vector<LoopStatus> list;
  for (const auto& [id, loop] : state_.loops) {
    const SessionEntry* entry = state_.Find(loop.session);
    if (entry == nullptr || (robot && entry->record.robot != *robot)) continue;
    list.push_back(StatusOf(loop));
  }
  return list;
}

absl::StatusOr<LoopStatus> PipelineImpl::DecideLoop(const LoopDecision& decision) {
  if (absl::Status status = CheckNote(decision.note); !status.ok()) return status;
  // Its session must not go while the store is written.
  std::lock_guard changing(membership_mutex_);
  LoopClosure loop;
  {
    std::lock_guard lock(state_.mutex);
    const auto it = state_.loops.find(decision.id);
    if (it == state_.loops.end()) {
      return absl::NotFoundError(absl::StrCat("no loop closure ", decision.id,
                                              ": list those there are; retired submaps' are gone"));
    }
    loop = it->second;
  }
  loop.rejected = decision.rejected;
  loop.note = decision.note;
  if (absl::Status status = state_.PutWord({.loops = {loop}}); !status.ok()) return status;
  state_.WaitUntilPlaced();
  std::lock_guard lock(state_.mutex);
  return StatusOf(loop);
}

absl::StatusOr<int64_t> PipelineImpl::PutAnchor(Anchor anchor) {
  if (absl::Status status = CheckAnchor(anchor); !status.ok()) return status;
  std::lock_guard changing(membership_mutex_);
  {
    std::lock_guard lock(state_.mutex);
    const SessionEntry* entry = state_.Find(anchor.submap.session);
    if (entry == nullptr || !entry->FindSubmap(anchor.submap.index)) {
      return absl::NotFoundError(
          absl::StrCat("no submap ", ToString(anchor.submap), ": list those there are"));
    }
  }
  anchor.given_ns = clock_.NowNs();
  if (absl::Status status = state_.PutAnchor(anchor); !status.ok()) return status;
  return RevisionOncePlaced();
}

absl::StatusOr<int64_t> PipelineImpl::RemoveAnchor(const SubmapId& submap) {
  std::lock_guard changing(membership_mutex_);
  {
    std::lock_guard lock(state_.mutex);
    if (!state_.anchors.contains(submap)) {
      return absl::NotFoundError(absl::StrCat("submap ", ToString(submap), " has no anchor"));
    }
  }
  if (absl::Status status = state_.RemoveAnchor(submap); !status.ok()) return status;
  return RevisionOncePlaced();
}

std::vector<Anchor> PipelineImpl::ListAnchors() {
  std::lock_guard lock(state_.mutex);
  std::vector<Anchor> list;
  for (const auto& [submap, anchor] : state_.anchors) list.push_back(anchor);
  return list;
}

absl::StatusOr<std::string> PipelineImpl::ExportPoseGraph(uint32_t component) {
  return placement_->WriteG2o(component);
}

}  // namespace isthmus::server
