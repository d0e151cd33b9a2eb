// Sessions in frames: which hang together by matches taken to be true, and how they lie there.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "server/match_graph/cycle_search.h"

namespace isthmus::match_graph {

// Keeps a reference to the nodes. Not thread safe.
class RigidGroups {
 public:
  // Each node in a frame of its own.
  explicit RigidGroups(const std::vector<CycleNode>& nodes);

  // Makes one frame of two. Nodes of one frame stay as they lie.
  void Join(uint32_t a, uint32_t b, const Pose& T_a_b);

  uint32_t FrameOf(uint32_t node) const { return frame_[node]; }  // Its smallest node.
  bool Together(uint32_t a, uint32_t b) const { return frame_[a] == frame_[b]; }
  // From odom to the frame's, which is the odom frame of its smallest node.
  const Pose& T_frame_odom(uint32_t node) const { return T_frame_odom_[node]; }

  // The steps from a to b along the joints; none from a node to itself. They are in one frame.
  std::vector<Step> Path(uint32_t a, uint32_t b) const;

 private:
  const std::vector<CycleNode>& nodes_;
  std::vector<uint32_t> frame_;
  std::vector<Pose> T_frame_odom_;
  std::vector<std::vector<std::pair<uint32_t, Pose>>> joints_;  // (j, T_i_j) of i.
};

}  // namespace isthmus::match_graph
