#include "server/match_graph/rigid_groups.h"

#include <algorithm>

namespace isthmus::match_graph {

RigidGroups::RigidGroups(const std::vector<CycleNode>& nodes)
    : nodes_(nodes), frame_(nodes.size()), T_frame_odom_(nodes.size()), joints_(nodes.size()) {
  for (uint32_t i = 0; i < nodes.size(); ++i) frame_[i] = i;
}

void RigidGroups::Join(uint32_t a, uint32_t b, const Pose& T_a_b) {
  if (Together(a, b)) return;
  joints_[a].emplace_back(b, T_a_b);
  joints_[b].emplace_back(a, T_a_b.Inverse());
  const uint32_t root = std::min(frame_[a], frame_[b]), gone = std::max(frame_[a], frame_[b]);
  const Pose T_fa_fb = T_frame_odom_[a] * T_a_b * T_frame_odom_[b].Inverse();
  const Pose T_root_gone = frame_[a] == root ? T_fa_fb : T_fa_fb.Inverse();
  for (uint32_t i = 0; i < frame_.size(); ++i) {
    if (frame_[i] != gone) continue;
    frame_[i] = root;
    T_frame_odom_[i] = T_root_gone * T_frame_odom_[i];
  }
}

std::vector<Step> RigidGroups::Path(uint32_t a, uint32_t b) const {
  // Searched from b, so that following the predecessors leads from a to b.
  constexpr uint32_t kUnreached = ~uint32_t{0};  // Layout
  std::vector<uint32_t> next(nodes_.size(), kUnreached), open = {b};
  next[b] = b;
  for (size_t k = 0; k < open.size() && next[a] == kUnreached; ++k) {
    for (const auto& [j, T] : joints_[open[k]]) {
      if (next[j] != kUnreached) continue;
      next[j] = open[k];
      open.push_back(j);
    }
  }
  std::vector<Step> steps;
  for (uint32_t i = a; i != b; i = next[i]) {
    const auto joint = std::find_if(joints_[i].begin(), joints_[i].end(),
                                    [&](const auto& entry) { return entry.first == next[i]; });
    steps.push_back({&nodes_[i], joint->second});
  }
  return steps;
}

}  // namespace isthmus::match_graph
