#include "client/simulation/route.h"

#include <absl/strings/str_cat.h>

#include <cmath>
#include <memory>
#include <numbers>

namespace isthmus::simulation {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// The tour's corners, moved about within the lane, as evenly spaced points; and the index of the
// one at which all places have been seen.
struct Polygon {
  std::vector<Eigen::Vector2d> points;
  size_t done = 0;

  Polygon(const World& world, const ClosedWalk& tour, Random& random) {
    std::vector<Eigen::Vector2d> lane;  // The robot passes each node at one and the same point.
    for (size_t i = 0; i < world.roads.nodes.size(); ++i) {
      const double m = world.roads.movable[i] ? world.lane_m : 0;
      lane.push_back(world.roads.nodes[i] +
                     Eigen::Vector2d(random.Uniform(-m, m), random.Uniform(-m, m)));
    }
    const double spacing = world.max_speed_mps > 2 ? 2.5 : 0.7;
    const size_t count = tour.nodes.size();
    for (size_t i = 0; i < count; ++i) {
      if (i == tour.done) done = points.size();
      const Eigen::Vector2d from = lane[tour.nodes[i]], to = lane[tour.nodes[(i + 1) % count]];
      const int steps = std::max(1, static_cast<int>(std::lround((to - from).norm() / spacing)));
      for (int k = 0; k < steps; ++k) points.push_back(from + (to - from) * k / steps);
    }
  }
};

SpeedLimits Limits(const World& world) {
  SpeedLimits limits;
  limits.speed_mps = world.max_speed_mps;
  if (world.max_speed_mps > 2) {
    limits.acceleration_mps2 = 1.0;
    limits.lateral_mps2 = 1.5;
    limits.yaw_rate_radps = 0.6;
  }
  return limits;
}

// A tour driven for `seconds`.
struct Drive {
  ClosedCurve curve;
  SpeedProfile profile;
  double done_s;  // When all places have been seen; infinity if later than `seconds`.

  Drive(const World& world, const Polygon& polygon, double seconds)
      : curve(polygon.points),
        profile(curve, Limits(world), seconds),
        done_s(profile.TimeAt(curve.LengthTo(polygon.done))) {}
};

Pose SensorPose(const World& world, const Drive& drive, double phase, double seconds) {
  const SpeedProfile::State state = drive.profile.At(seconds);
  const ClosedCurve::Sample at = drive.curve.At(state.s);
  const double x = at.position.x(), y = at.position.y();
  // The ground's slope ahead and to the left, over the robot's own size.
  const double c = std::cos(at.yaw), s = std::sin(at.yaw);
  const auto rise = [&](double dx, double dy) {
    return world.ground.Height(x + dx, y + dy) - world.ground.Height(x - dx, y - dy);
  };
  const double slope_ahead = std::atan(rise(0.5 * c, 0.5 * s));
  const double slope_left = std::atan(rise(-0.5 * s, 0.5 * c));
  const double sway = 0.5 * kDegree * state.speed_mps / world.max_speed_mps;
  const double t = 2 * std::numbers::pi * seconds;
  const double roll = slope_left + sway * std::sin(0.9 * t + phase);
  const double pitch = -slope_ahead + sway * std::sin(0.6 * t + 2 * phase);
  const double z = world.ground.Height(x, y) + world.sensor_height_m;
  return Pose::FromXyzRpy(x, y, z, roll, pitch, at.yaw);
}

// The way of robot i around a plan's places; null if there is none.
std::shared_ptr<const Drive> MakeDrive(const World& world, const std::vector<int>& places,
                                       int robot, double seconds, uint64_t seed) {
  Random random(seed, 0x71, static_cast<uint64_t>(robot));
  const ClosedWalk tour = Tour(world.roads, places, random);
  if (tour.nodes.empty()) return nullptr;
  return std::make_shared<Drive>(world, Polygon(world, tour, random), seconds);
}

// The longest tours that fit in the time, of as many places for every robot; the shortest if none
// fit. No drives if there is no way for some robot.
std::vector<std::shared_ptr<const Drive>> ChooseDrives(const World& world, int robots,
                                                       double seconds, uint64_t seed) {
  const int places = static_cast<int>(world.roads.places.size());
  std::vector<std::shared_ptr<const Drive>> drives;
  for (int size = std::max(1, places / (robots + 1)); size >= 1; --size) {
    Random random(seed, 0x70, 0);  // The same for every size: they differ in nothing else.
    const auto plan = world.fixed_tours.empty() ? PlanTours(world.roads, robots, size, size, random)
                                                : world.fixed_tours;
    std::vector<std::shared_ptr<const Drive>> these;
    double slowest = 0;
    for (int i = 0; i < robots; ++i) {
      auto drive = MakeDrive(world, plan[i % plan.size()], i, seconds + 1, seed);
      if (drive == nullptr) break;
      slowest = std::max(slowest, drive->done_s);
      these.push_back(std::move(drive));
    }
    if (static_cast<int>(these.size()) < robots) continue;
    drives = std::move(these);
    if (slowest <= seconds) break;
  }
  return drives;
}

}  // namespace

absl::StatusOr<std::vector<Motion>> MakeRoutes(const World& world, int robots, double seconds,
                                               uint64_t seed) {
  if (robots < 1 || !(seconds > 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("routes need at least one robot and more than 0 seconds; got ", robots,
                     " robots and ", seconds, " s"));
  }
  const auto shared_world = std::make_shared<World>();
  *shared_world = world;
  shared_world->mesh = {};  // Motions need the ground only.
  std::vector<Motion> motions;
  const auto drives = ChooseDrives(world, robots, seconds, seed);
  if (drives.empty()) {
    return absl::InternalError(absl::StrCat("world ", world.name, " with seed ", seed,
                                            " has no way for ", robots,
                                            " robots; choose another seed"));
  }
  for (size_t i = 0; i < drives.size(); ++i) {
    Random random(seed, 0x72, i);
    const double phase = random.Uniform(0, 2 * std::numbers::pi);
    motions.push_back([shared_world, drive = drives[i], phase](double t) {
      return SensorPose(*shared_world, *drive, phase, t);
    });
  }
  return motions;
}

std::vector<Motion> MakeWalks(const World& world, int count, double seconds, uint64_t seed) {
  if (count <= 0) return {};
  constexpr double kLongestHeadStart = 60;  // Seconds.
  World streets = world;
  streets.mesh = {};
  streets.max_speed_mps = 1.3;
  streets.lane_m += 0.3;
  const int places = static_cast<int>(world.roads.places.size());
  std::vector<Motion> walks;
  for (int i = 0; i < count && places > 0; ++i) {
    Random random(seed, 0x73, static_cast<uint64_t>(i));
    const int from = random.Index(places), to = random.Index(places);
    ClosedWalk tour = Tour(streets.roads, {from, to}, random);
    if (tour.nodes.empty()) tour = Tour(streets.roads, {from}, random);
    if (tour.nodes.empty()) continue;
    const double head_start = random.Uniform(5, kLongestHeadStart);
    const auto drive = std::make_shared<Drive>(streets, Polygon(streets, tour, random),
                                               seconds + kLongestHeadStart + 1);
    walks.push_back([ground = world.ground, drive, head_start](double t) {
      const auto at = drive->curve.At(drive->profile.At(t + head_start).s);
      const double z = ground.Height(at.position.x(), at.position.y());
      return Pose::FromXyzRpy(at.position.x(), at.position.y(), z, 0, 0, at.yaw);
    });
  }
  return walks;
}

}  // namespace isthmus::simulation
