// The way along one session to an edge that joins it to another, and from there along the other: as
// if one robot had driven it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "core/map/match.h"
#include "server/matching/loops/loop_candidates.h"
#include "server/matching/loops/loop_submaps.h"
#include "server/matching/prepared/prepared_map.h"

namespace isthmus::matching {

// A map with the joint poses of its submaps and the way to the middle of each.
struct JoinedMap {
  JoinedMap(const PreparedMap& prepared, const std::vector<Pose>& joint_poses)
      : map(&prepared),
        poses(&joint_poses),
        path_lengths(PathLengths(prepared.session_map().submaps)) {}

  const PreparedMap* map;
  const std::vector<Pose>* poses;
  std::vector<double> path_lengths;
};

// Submaps are numbered anew along the way, those of the old map first. Both maps must outlive it.
// Not thread safe.
class JoinedWay {
 public:
  // Along `old` from its first or, backwards, its last submap to the edge's submap_a; from its
  // submap_b along `fresh` to the last or the first submap. `prepared_submaps` as in LoopOptions.
  JoinedWay(const JoinedMap& old, const JoinedMap& fresh, const SubmapEdge& join,
            bool old_backwards, bool fresh_backwards, size_t prepared_submaps);

  // As of the submap of `fresh` at this position, which is on the way. `edges`, positions of old on
  // positions of fresh, join the maps.
  LoopScene SceneAt(size_t fresh, const std::vector<SubmapEdge>& edges,
                    const pose_graph::DriftModel& drift) const;

  size_t old_count() const { return old_count_; }
  LoopSubmaps& submaps() { return *submaps_; }
  // The position in its map of a submap on the way.
  uint32_t PositionOf(size_t on_way) const {
    return static_cast<uint32_t>(stops_[on_way].position);
  }

 private:
  struct Stop {
    const JoinedMap* of = nullptr;
    size_t position = 0;
  };

  void AddStops(const JoinedMap& map, size_t from, size_t to);
  // The submap of the stop without its points, in the frame of the old map.
  std::shared_ptr<const Submap> Outline(size_t stop, const Pose& T_old_odom) const;
  // The covariance of the step from the stop before, which may be the next of its session.
  Matrix6d StepCovariance(size_t stop) const;
  std::vector<LoopEdge> EdgesAmong(size_t count, const std::vector<SubmapEdge>& edges) const;

  const JoinedMap* const old_;
  const JoinedMap* const fresh_;
  std::vector<Stop> stops_;
  std::map<std::pair<const JoinedMap*, size_t>, size_t> on_way_;
  size_t old_count_ = 0;
  std::vector<std::shared_ptr<const Submap>> outlines_;
  std::vector<double> path_lengths_;
  std::map<uint32_t, double> radii_m_;
  std::unique_ptr<LoopSubmaps> submaps_;
};

}  // namespace isthmus::matching
