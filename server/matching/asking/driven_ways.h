// The ways that two robots have driven, laid on each other as a hypothesis has their maps. A robot
// that could drive a way can drive it again, and so can the other.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/range_image.h"
#include "core/pose.h"
#include "server/matching/prepared/map_poses.h"
#include "server/matching/prepared/prepared_map.h"

namespace isthmus::matching {

// A place where a robot was, and its view from there.
struct Stop {
  bool of_b = false;
  uint32_t submap = 0;  // Position in its map.
  Pose T_submap_sensor;
  Pose T_level_sensor;  // The level frame is a's odom frame, turned so that z is up.
  const RangeImage* view = nullptr;
};

// Easiest ways from one stop to all others.
struct EasiestWays {
  std::vector<std::optional<size_t>> before;  // The stop before; none: it is not reached, or first.
  std::vector<double> length_m;               // Infinite: it is not reached.
};

// Not thread safe. The maps must outlive it.
class DrivenWays {
 public:
  DrivenWays(const PreparedMap& a, const PreparedMap& b, const MapPoses& poses);

  const std::vector<Stop>& stops() const { return stops_; }
  // The last place of one of the robots; nothing where it has no views.
  std::optional<size_t> Newest(bool of_b) const { return newest_[of_b ? 1 : 0]; }
  // Along the ways as driven, over shortcuts, and across from one robot's to the other's where
  // either sees that nothing stands between. Where nobody has driven a metre counts kUndriven times
  // (Dijkstra, "A note on two problems in connexion with graphs", 1959).
  EasiestWays From(size_t stop) const;

 private:
  struct Link {
    size_t to = 0;
    double length_m = 0;
    bool driven = false;
  };
  void AddStops(const PreparedMap& map, const std::vector<Pose>& poses, bool of_b,
                const Pose& T_level_a);
  void LinkStops();

  std::vector<Stop> stops_;  // Each robot's in order, a's first.
  std::optional<size_t> newest_[2];
  std::vector<std::vector<Link>> links_;  // By stop.
};

}  // namespace isthmus::matching
