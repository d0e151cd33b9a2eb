// The keeper of a session's shape from submap to submap and loop to loop.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "core/map/loop_closure.h"
#include "core/map/revision.h"
#include "server/matching/prepared/session_shape.h"

namespace isthmus::matching {

// Keeps the shape of one session, and the submaps as they lie in the shape that it is matched by.
// That one stays as it is, and grows, until loops have moved it by more than matching notices
// (limits.h): whatever was made of it holds until then. Not thread safe. Deterministic for the same
// sequence of calls; after a restart the shapes differ by no more than what goes unnoticed.
class ShapeKeeper {
 public:
  // `submaps` are the session's as odometry has them, in order of index: those of the last call
  // without retired ones, and newer ones. `loops` are all of the session. Across a gap that retired
  // submaps left the step is that between its ends when it came: by the shape at that time, or,
  // unknown, by where `published` has them; null: by odometry. Loops move a session that is not
  // `finished` only when it has grown, so that the cost stays in proportion to its length.
  //
  // True if submaps of the last call have moved. Their first submap keeps its place.
  bool Update(const SubmapList& submaps, const std::vector<LoopClosure>& loops, bool finished,
              const Placement* published);

  // As to be matched: those that odometry has where they belong are the very submaps given.
  const SubmapList& submaps() const { return held_; }
  std::shared_ptr<const SessionShape> shape() const { return shape_; }

 private:
  using LoopEdge =
      std::pair<uint64_t, uint32_t>;  // A loop's id, and the place of one of its edges.
  // The edges of loops that a problem has behind the steps, and what is known of them.
  struct Loops {
    std::vector<LoopEdge> keys;
    // Loops that went with retired submaps leave the shape that they had straightened.
    bool any_new = false, taken_back = false;
  };
  void FindGaps(const SubmapList& submaps, const Placement* published);
  std::vector<pose_graph::Edge> Steps(const SubmapList& submaps,
                                      const pose_graph::DriftModel& drift) const;
  Loops AddLoops(const SubmapList& submaps, const std::vector<LoopClosure>& loops,
                 pose_graph::Problem* problem) const;
  // Sets the start of the search: as it lay at the last call, or as the steps have it.
  void SetPoses(const SubmapList& submaps, const Loops& loops, pose_graph::Problem* problem) const;
  // Nothing is solved where no loop came or was taken back.
  SessionShape Solve(const SubmapList& submaps, const std::vector<LoopClosure>& loops,
                     bool* taken_back);
  // The poses to be matched by that follow from the shape; true in `moved` where it is taken as
  // it is.
  std::vector<Pose> PosesToHold(const SubmapList& submaps, const SessionShape& shape, bool may_move,
                                bool* moved) const;
  void Hold(const SubmapList& submaps, const std::vector<Pose>& poses);

  std::map<LoopEdge, double> weights_;                  // Loop edges that counted at the last call.
  std::map<std::pair<uint32_t, uint32_t>, Pose> gaps_;  // Steps, by the indices of their ends.
  std::shared_ptr<const SessionShape> shape_;
  SubmapList given_, held_;  // The last list as odometry has it, and as matched.
  size_t shaped_at_ = 0;     // Submaps when loops gave it its shape; 0: none has.
};

}  // namespace isthmus::matching
