// The maps that robots are found in, made of placed submaps and kept while robots ask.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "core/clock.h"
#include "core/concurrency/executor.h"
#include "core/concurrency/mutex.h"
#include "core/ids.h"
#include "core/map/submap.h"
#include "core/pose.h"
#include "floam/localise/localiser.h"
#include "server/map/map_view.h"

namespace isthmus::localisation {

// One component, as of one revision. Immutable.
struct PlacedMap {
  int64_t revision = 0;
  uint32_t component = 0;
  std::shared_ptr<const floam::LocalisationMap> map;
  std::map<SubmapId, Pose> places;  // T_map_submap of its submaps.
  double making_s = 0;
  int64_t made_ns = 0;
};

// The motion from coordinates of `before` to coordinates of `after` around a position in `before`:
// by the submap nearest to it that both hold. Empty if they have none in common.
std::optional<Pose> MotionBetween(const PlacedMap& before, const PlacedMap& after,
                                  const Eigen::Vector3d& position);

// Thread safe.
class LocalisationMaps {
 public:
  // `views` gives the map as it is now. Maps are made anew by the executor's threads.
  LocalisationMaps(std::function<std::shared_ptr<const server::MapView>()> views,
                   SubmapReader submaps, const Clock* clock, Executor* executor);
  ~LocalisationMaps();  // Waits for maps in the making.

  // The component that the newest session of the robot is in, or the largest. Made at once if there
  // is none yet; else as it was made last, and made anew by and by if it has changed. NotFound for
  // an unknown robot, FailedPrecondition while nothing of it is placed, Unavailable where that may
  // change by itself, as new submaps are being placed.
  absl::StatusOr<std::shared_ptr<const PlacedMap>> Get(const RobotId& in_map_of);

 private:
  absl::StatusOr<std::shared_ptr<const PlacedMap>> Make(const server::MapView& view,
                                                        uint32_t component) const;
  absl::StatusOr<std::shared_ptr<const PlacedMap>> MakeUnguarded(const server::MapView& view,
                                                                 uint32_t component) const;
  bool IsDue(const PlacedMap& made, int64_t revision) const;
  void MakeLater(uint32_t component);

  const std::function<std::shared_ptr<const server::MapView>()> views_;
  const SubmapReader submaps_;
  const Clock& clock_;
  Executor& executor_;
  const std::shared_ptr<Executor::Lane> lane_ = Executor::MakeLane();
  Mutex mutex_;
  CondVar changed_;
  // By component, if its map is asked for.
  std::map<uint32_t, std::shared_ptr<const PlacedMap>> made_ ABSL_GUARDED_BY(mutex_);
  std::set<uint32_t> making_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::localisation
