// The merged map as readers see it: an immutable snapshot made by composition, read by queries.
#pragma once

#include <absl/status/status.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/cloud.h"
#include "core/ids.h"
#include "core/map/submap.h"
#include "core/pose.h"

namespace isthmus {

// A submap and where it lies in its component's map frame. Its points are fetched when they are
// needed, see SubmapReader.
struct PlacedSubmap {
  std::shared_ptr<const SubmapInfo> submap;
  uint32_t component = 0;
  Pose T_map_submap;
};

// The part of the map to read. Everything given must hold.
struct Region {
  Box box;  // In the map frame; ignored when empty.
  bool has_sphere = false;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius_m = 0;
  uint32_t component = 0;
  int robot = -1;           // Index into ComposedMap::robots(); -1 for all.
  double resolution_m = 0;  // Thinned further to one point per such voxel; 0: as composed.
};

// Safe to read from many threads while newer ones are made.
class ComposedMap {
 public:
  // Receives a chunk; returns false to stop reading.
  using Emit = std::function<bool(const std::vector<MapPoint>&)>;

  virtual ~ComposedMap() = default;
  virtual int64_t revision() const = 0;
  // Robots in the map, sorted; MapPoint::robot indexes this.
  virtual const std::vector<RobotId>& robots() const = 0;
  virtual uint32_t component_count() const = 0;
  // 0 and an empty box for a component that does not exist.
  virtual uint64_t point_count(uint32_t component) const = 0;
  virtual Box bounds(uint32_t component) const = 0;
  // OK, or why there is nothing to read yet: Unavailable while the map of a store is composed for
  // the first time after a start, naming how far it has come.
  virtual absl::Status ready() const { return absl::OkStatus(); }
  // Placed submaps that could not be read and are missing from the map.
  virtual uint64_t missing_submaps() const { return 0; }
  // Calls `emit` with chunks of at most `chunk` points until done or it returns false, which is no
  // error. Anything but OK means that points are missing from what was emitted: ready(), or points
  // could not be read back from where they are kept.
  virtual absl::Status Read(const Region& region, size_t chunk, const Emit& emit) const = 0;
};

}  // namespace isthmus
