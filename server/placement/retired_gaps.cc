#include "server/placement/retired_gaps.h"

#include <utility>

#include "server/placement/initial_poses.h"

namespace isthmus::placement {
namespace {

Pose OdometryStep(const Node& a, const Node& b) {
  return a.T_odom_submap.Inverse() * b.T_odom_submap;
}

// As published; as odometry has it where one of them was not.
Pose PlacedStep(const Placement* placement, const Node& a, const Node& b) {
  const Pose* pose_a = placement == nullptr ? nullptr : FindPose(*placement, a.index);
  const Pose* pose_b = placement == nullptr ? nullptr : FindPose(*placement, b.index);
  if (pose_a == nullptr || pose_b == nullptr) return OdometryStep(a, b);
  return pose_a->Inverse() * *pose_b;
}

}  // namespace

void UpdateGaps(const std::vector<Placement>& previous, const Input& input, GapPoses* gaps) {
  GapPoses kept;
  for (const Session& session : input.sessions) {
    const SessionId& id = session.tree.session;
    for (size_t k = 0; k + 1 < session.nodes.size(); ++k) {
      const Node &a = session.nodes[k], &b = session.nodes[k + 1];
      if (b.index == a.index + 1) continue;
      const std::tuple key(id, a.index, b.index);
      const auto known = gaps->find(key);
      kept.emplace(key, known != gaps->end() ? known->second
                                             : PlacedStep(FindPlacement(previous, id), a, b));
    }
  }
  *gaps = std::move(kept);
}

Pose StepBetween(const SessionId& session, const Node& a, const Node& b, const GapPoses& gaps) {
  if (b.index == a.index + 1) return OdometryStep(a, b);
  const auto gap = gaps.find({session, a.index, b.index});
  return gap == gaps.end() ? OdometryStep(a, b) : gap->second;
}

}  // namespace isthmus::placement
