// The localiser: finds and follows a robot in a finished map, to which it adds nothing.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/map/submap.h"
#include "core/pose.h"
#include "core/scan.h"
#include "floam/map/map_memory.h"
#include "floam/match/match_quality.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/relocalise/place_check.h"
#include "floam/relocalise/relocaliser.h"
#include "floam/rings/sensor_model.h"

namespace isthmus::floam {

// A map to be found in. Build it, then share it: reading it is thread safe.
class LocalisationMap {
 public:
  // `R_level_map`: turns the map's frame so that z points up.
  explicit LocalisationMap(const Eigen::Quaterniond& R_level_map = Eigen::Quaterniond::Identity());

  // In order of time: of things that were moved the later place is kept.
  void Add(const Submap& submap, const Pose& T_map_submap);

  const Pose& T_level_map() const { return T_level_map_; }
  const std::shared_ptr<MapMemory>& memory() const { return memory_; }

 private:
  const Pose T_level_map_;
  const std::shared_ptr<MapMemory> memory_;
  uint32_t submaps_ = 0;
};

enum class LocalisationStatus : uint8_t {
  kSearching,  // The place is not known.
  kAmbiguous,  // Several places look alike.
  kLocated,
  kUncertain,  // Led by odometry from a known place: beyond the map, or contradicted by it.
};

struct LocalisationResult {
  OdometryResult odometry;  // In a frame of the localiser's own.
  LocalisationStatus status = LocalisationStatus::kSearching;
  // While located or uncertain; at the END of the scan. The covariance is that of a twist [rho;
  // phi], sensor frame, m^2 and rad^2.
  Pose T_map_sensor;
  Matrix6d covariance = Matrix6d::Zero();
  Pose T_map_odom;
  double localising_ms = 0;  // Beside the odometry.

  bool has_pose() const {
    return status == LocalisationStatus::kLocated || status == LocalisationStatus::kUncertain;
  }
};

// Odometry tells the motion, as for a robot that maps; the map tells where that is. The first place
// is the relocaliser's (see there: of twins neither is claimed, and the robot must stand about
// level), each scan after it is matched to the map and weighed against what odometry may have
// drifted, in the manner of a Kalman filter over SE(3) (Barfoot, "State Estimation for Robotics",
// section 8.2). Beyond the map odometry goes on alone, and the covariance grows. A scan that fits
// the map badly where there is one changes nothing; for two seconds, and the robot is looked for
// anew. Not thread safe; starts no threads.
class Localiser {
 public:
  Localiser(const SensorModel& sensor, const OdometryOptions& options);

  // Also while under way: the same map as it grows, or moves by a loop; the place is kept, moved by
  // `T_new_old`, and checked with the next scan.
  void SetMap(std::shared_ptr<const LocalisationMap> map, const Pose& T_new_old = Pose());
  // Another map: the place is forgotten.
  void SetMapAnew(std::shared_ptr<const LocalisationMap> map);

  // Errors as Odometry::Process; scans in order of time.
  absl::StatusOr<LocalisationResult> Process(const Scan& scan);

 private:
  // A scan's verdict on the place where it should be.
  enum class Sight { kFits, kNothingThere, kContradicts };

  void Predict(const OdometryResult& odometry);
  Sight Look(const PlaceMatch& place, const Pose& T_level_expected) const;
  void Correct(const PlaceMatch& place, const Pose& T_level_expected);
  void Follow(const OdometryResult& odometry);
  void Search(const OdometryResult& odometry);
  void Forget();
  ScanPose GuessAt(const Pose& T_level_sensor) const;
  LocalisationStatus Status() const;

  const OdometryOptions options_;
  Odometry odometry_;
  Relocaliser relocaliser_;
  PlaceCheck check_;
  ScanImage image_;
  std::shared_ptr<const LocalisationMap> map_;

  uint32_t segment_ = 0;               // The odometry's segment at the last scan.
  Pose T_odom_last_;                   // Pose of the last scan.
  int64_t last_ns_ = 0;                // Its stamp; 0: there was none.
  Vector6d twist_ = Vector6d::Zero();  // Between the last two.
  std::optional<Pose> T_level_odom_;   // While the place is known.
  Matrix6d covariance_ = Matrix6d::Zero();
  bool fits_ = false;  // The last scan did.
  double contradicted_s_ = 0;
  double since_walls_s_ = 0;  // Since it was last looked at the walls.
};

}  // namespace isthmus::floam
