// A map that is still being loaded: what readers get of a stored map while it is composed for the
// first time after a start, rather than a map that looks empty.
#pragma once

#include <absl/strings/str_cat.h>

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/map/composed_map.h"

namespace isthmus::server {

// Thread safe.
class LoadingMap : public ComposedMap {
 public:
  LoadingMap(std::vector<RobotId> robots, uint32_t components)
      : robots_(std::move(robots)), components_(components) {}

  // Sets the share of the work that is done; from 0 to 1.
  void SetDone(double share) { percent_ = static_cast<int>(100 * share); }
  // Sets why it could not be done when it was last tried; empty: it is under way.
  void SetProblem(const std::string& problem) {
    MutexLock lock(&mutex_);
    problem_ = problem;
  }

  int64_t revision() const override { return 0; }
  const std::vector<RobotId>& robots() const override { return robots_; }
  uint32_t component_count() const override { return components_; }
  uint64_t point_count(uint32_t) const override { return 0; }
  Box bounds(uint32_t) const override { return {}; }
  absl::Status ready() const override {
    MutexLock lock(&mutex_);
    if (!problem_.empty()) {
      return absl::UnavailableError(
          absl::StrCat("the map cannot be composed after the start: ", problem_));
    }
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
  mutable Mutex mutex_;
  std::string problem_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::server
