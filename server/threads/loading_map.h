// A map that is still being loaded: what readers get of a stored map while it is composed for the
// first time after a start, rather than a map that looks empty.
#pragma once

#include <absl/strings/str_cat.h>

#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/map/composed_map.h"

namespace isthmus::server {

// Thread safe.
class LoadingMap : public ComposedMap {
 public:
  LoadingMap(std::vector<RobotId> robots, uint32_t components)
      : robots_(std::move(robots)), components_(components) {}

  // Sets the share of the work that is done; from 0 to 1.
  void SetDone(double share) { percent_ = static_cast<int>(100 * share); }

  int64_t revision() const override { return 0; }
  const std::vector<RobotId>& robots() const override { return robots_; }
  uint32_t component_count() const override { return components_; }
  uint64_t point_count(uint32_t) const override { return 0; }
  Box bounds(uint32_t) const override { return {}; }
  absl::Status ready() const override {
    return absl::UnavailableError(absl::StrCat("the map is being composed after the start, ",
                                               percent_.load(), " % so far: try again"));
  }
  absl::Status Read(const Region&, size_t, const Emit&) const override { return ready(); }
  absl::StatusOr<TileInfo> FindTile(const TileId&) const override { return ready(); }
  absl::StatusOr<std::vector<MapPoint>> ReadTile(const TileId&) const override { return ready(); }

 private:
  const std::vector<RobotId> robots_;
  const uint32_t components_;
  std::atomic<int> percent_ = 0;
};

}  // namespace isthmus::server
