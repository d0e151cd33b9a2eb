// Robots with LiDARs driving through a procedural world.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/map/trajectory.h"
#include "core/scan.h"
#include "lab/simulation/route.h"
#include "lab/simulation/sensors/effects.h"
#include "lab/simulation/sensors/lidar.h"
#include "lab/simulation/sensors/ray_caster.h"
#include "lab/simulation/worlds/another_day.h"
#include "lab/simulation/worlds/world.h"

namespace isthmus::simulation {

// The noise of a measurement. All zero: exact.
struct Noise {
  double range_sigma_m = 0.02;  // Standard deviation along the ray.
  double dropout = 0.005;       // Share of measurements lost by chance, [0, 1].
  // Returns weaker than this are lost ever more often. The strength is reflectivity * cosine of
  // the incidence / (range / maximum range)^2: dark ground fades out at 30 to 40 m.
  double min_strength = 12;
};

// A point's intensity: brightness, or the truth for who judges maps. All else of the point is the
// same, whichever it is.
enum class Truth {
  kNone,    // Brightness.
  kMoving,  // 255 of people and cars, at most 254 of all else.
  kClass,   // The number of its PointClass.
};

struct Options {
  // See MakeWorld; or wild-KIND, one of WildKinds, which draws noise, effects, walkers and cars by
  // itself.
  std::string world = "museum";
  std::string sensor = "vlp16";  // See MakeLidar.
  int robots = 2;
  double seconds = 60;
  int walkers = 0;    // People walking about among the robots, 0 to 1000.
  int cars = 0;       // Cars driving along the streets, 0 to 100; only where there are streets.
  int parked = 0;     // Cars that stand beside the streets at first and are gone later, likewise.
  uint64_t seed = 1;  // For the world, the routes and the noise.
  // 1: the world as it is made. On later days, at the same hour, routes, people and noise are
  // others, and so many pieces of furniture were moved since the first; see MoveFurniture.
  int day = 1, moved = 0;
  Noise noise = {};
  Effects effects = {};
  Truth truth = Truth::kNone;
  int64_t start_stamp_ns = 1'600'000'000'000'000'000;  // Unix time at which every robot sets out.
};

// People and cars among the robots; see Walkers and Cars.
struct Actors {
  std::vector<Motion> walks, cars;
};

// Deterministic: the same options give the same scans, in whatever order they are asked for.
// Thread safe.
class Simulator {
 public:
  // InvalidArgument, saying what is allowed, for options that make no sense; also for several
  // robots in a wild world, see CreateTeam.
  static absl::StatusOr<std::unique_ptr<Simulator>> Create(const Options& options);
  // All robots of the options: one simulator with all of them, or in a wild world a simulator for
  // each, as each has a carrier and faults of its own (DrawWildTeamDrive). Errors likewise.
  static absl::StatusOr<std::vector<std::unique_ptr<Simulator>>> CreateTeam(const Options& options);
  // For a world and motions of one's own; there are walkers and cars if the world has roads;
  // `options.world` and `options.sensor` are not read.
  Simulator(World world, std::vector<Motion> motions, Lidar lidar, const Options& options);
  // The same with actors of one's own.
  Simulator(World world, std::vector<Motion> motions, Actors actors, Lidar lidar,
            const Options& options);

  const Options& options() const { return options_; }
  const World& world() const { return world_; }
  const Lidar& lidar() const { return lidar_; }
  // Things that came and went since the first day.
  const std::vector<MovedVolume>& moved() const { return moved_; }
  int robots() const { return static_cast<int>(motions_.size()); }
  // Scans of each robot.
  int scan_count() const;
  // The stamp that comes with a scan.
  int64_t Stamp(int robot, int index) const;

  // The index-th turn of a robot's sensor, counted from 0; every firing is cast from the pose at
  // its own time. Points in order of firing, with ring and time; sequence is index + 1. Requires
  // 0 <= robot < robots() and index >= 0; may go beyond scan_count().
  Scan MakeScan(int robot, int index) const;

  // T_world_sensor at the END of that scan; its stamp is the scan's but for Effects.
  StampedPose Truth(int robot, int index) const;
  Trajectory Truth(int robot) const;
  // T_world_sensor at any time.
  Pose PoseAt(int robot, double seconds) const { return motions_[robot](seconds); }

 private:
  // The ray of every firing of a turn that begins at `begin_s`.
  std::vector<Ray> Aim(int robot, double begin_s, std::span<const Firing> firings) const;

  // All constant after construction, but for what Create fills in.
  Options options_;
  uint64_t day_seed_ = 0;  // For the differences between the days.
  std::vector<MovedVolume> moved_;
  World world_;
  std::vector<Motion> motions_;
  Actors actors_;
  Lidar lidar_;
  Miscalibration miscalibration_;
  RayCaster caster_;
};

}  // namespace isthmus::simulation
