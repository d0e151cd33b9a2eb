#include "lab/simulation/route.h"

#include <absl/strings/str_cat.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "core/geometry/angles.h"

namespace isthmus::simulation {
namespace {

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

// Nodding and rolling of the sensor.
struct Sway {
  double phase = 0;
  double roll_hz = 0.9, pitch_hz = 0.6;
};

Pose SensorPose(const World& world, const ClosedCurve& curve, const SpeedProfile::State& state,
                const Sway& swaying, double seconds) {
  const ClosedCurve::Sample at = curve.At(state.s);
  const double x = at.position.x(), y = at.position.y();
  // The ground's slope ahead and to the left, over the robot's own size.
  const double c = std::cos(at.yaw), s = std::sin(at.yaw);
  const auto rise = [&](double dx, double dy) {
    return world.ground.Height(x + dx, y + dy) - world.ground.Height(x - dx, y - dy);
  };
  const double slope_ahead = std::atan(rise(0.5 * c, 0.5 * s));
  const double slope_left = std::atan(rise(-0.5 * s, 0.5 * c));
  const double sway = 0.5 * kRadPerDeg * state.speed_mps / world.max_speed_mps;
  const double t = 2 * std::numbers::pi * seconds;
  const double roll = slope_left + sway * std::sin(swaying.roll_hz * t + swaying.phase);
  const double pitch = -slope_ahead + sway * std::sin(swaying.pitch_hz * t + 2 * swaying.phase);
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

// A copy for motions, which need the ground only.
std::shared_ptr<const World> WithoutMesh(const World& world) {
  auto copy = std::make_shared<World>(world);
  copy->mesh = {};
  return copy;
}

absl::Status NoWay(const World& world, int robots, uint64_t seed) {
  return absl::InternalError(absl::StrCat("world ", world.name, " with seed ", seed,
                                          " has no way for ", robots,
                                          " robots; choose another seed"));
}

// When a drive has come `s` metres; TimeAt to the last bit.
double WhenAt(const SpeedProfile& profile, double s, double latest_s) {
  double early = 0, late = latest_s;
  for (int halving = 0; halving < 64; ++halving) {
    const double middle = (early + late) / 2;
    (profile.At(middle).s < s ? early : late) = middle;
  }
  return late;
}

// The motion of the point on the ground, x ahead, `right_m` beside a tour between two places chosen
// at random (less in bends, which would else be turned on the spot), under way since up to a
// minute; null if there is no tour.
Motion MakeStroll(const World& world, double right_m, double seconds, Random& random) {
  constexpr double kLongestHeadStart = 60;  // Seconds.
  const int places = static_cast<int>(world.roads.places.size());
  if (places == 0) return nullptr;
  const int from = random.Index(places), to = random.Index(places);
  ClosedWalk tour = Tour(world.roads, {from, to}, random);
  if (tour.nodes.empty()) tour = Tour(world.roads, {from}, random);
  if (tour.nodes.empty()) return nullptr;
  const double head_start = random.Uniform(5, kLongestHeadStart);
  const auto drive =
      std::make_shared<Drive>(world, Polygon(world, tour, random), seconds + kLongestHeadStart + 1);
  return [ground = world.ground, drive, head_start, right_m](double t) {
    const auto at = drive->curve.At(drive->profile.At(t + head_start).s);
    const double right = right_m / (1 + right_m * std::abs(at.curvature));
    const double x = at.position.x() + right * std::sin(at.yaw);
    const double y = at.position.y() - right * std::cos(at.yaw);
    return Pose::FromXyzRpy(x, y, ground.Height(x, y), 0, 0, at.yaw);
  };
}

}  // namespace

absl::StatusOr<std::vector<Motion>> MakeRoutes(const World& world, int robots, double seconds,
                                               uint64_t seed) {
  if (robots < 1 || !(seconds > 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("routes need at least one robot and more than 0 seconds; got ", robots,
                     " robots and ", seconds, " s"));
  }
  const auto shared_world = WithoutMesh(world);
  std::vector<Motion> motions;
  const auto drives = ChooseDrives(world, robots, seconds, seed);
  if (drives.empty()) return NoWay(world, robots, seed);
  for (size_t i = 0; i < drives.size(); ++i) {
    Random random(seed, 0x72, i);
    const Sway sway{random.Uniform(0, 2 * std::numbers::pi)};
    motions.push_back([shared_world, drive = drives[i], sway](double t) {
      return SensorPose(*shared_world, drive->curve, drive->profile.At(t), sway, t);
    });
  }
  return motions;
}

absl::StatusOr<Lap> MakeLap(const World& world, double about_s, double turn_s, uint64_t seed,
                            const TeamMember& member) {
  if (!(about_s > 0 && turn_s > 0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a lap and a turn need more than 0 seconds; got ", about_s, " s and ", turn_s, " s"));
  }
  if (member.robot < 0 || member.robot >= member.robots) {
    return absl::InvalidArgumentError(
        absl::StrCat("there is no robot ", member.robot, " of ", member.robots));
  }
  const auto drives = ChooseDrives(world, member.robots, about_s, seed);
  if (drives.empty()) return NoWay(world, member.robots, seed);
  const auto& drive = drives[member.robot];
  const ClosedCurve& curve = drive->curve;
  const SpeedLimits limits = Limits(world);
  // The run-up, after which the start from rest is felt no more; and the way beyond the lap, so
  // that the lap's end slows down for the bends that follow.
  const double run_up_m = 1 + limits.speed_mps * limits.speed_mps / (2 * limits.acceleration_mps2);
  const double beyond_m = 2 * run_up_m;
  auto profile = std::make_shared<const SpeedProfile>(
      curve, limits, (run_up_m + curve.length() + beyond_m) / limits.speed_mps);
  const double latest = profile->TimeAt(run_up_m + curve.length() + 1);
  const double from = WhenAt(*profile, run_up_m, latest);
  const double to = WhenAt(*profile, run_up_m + curve.length(), latest);

  Lap lap;
  lap.begin_s = turn_s * std::ceil((from + 1) / turn_s);
  lap.seconds = turn_s * std::round((to - from) / turn_s);
  const double speed_up = (to - from) / lap.seconds;
  const auto whole = [&lap](double hz) { return std::round(hz * lap.seconds) / lap.seconds; };
  const Sway sway{0, whole(0.9), whole(0.6)};
  lap.motion = [shared_world = WithoutMesh(world), drive, profile, from, speed_up, sway,
                begin_s = lap.begin_s, lap_s = lap.seconds](double t) {
    double since = t - begin_s;
    if (since >= 0) since = std::fmod(since, lap_s);
    SpeedProfile::State state = profile->At(from + since * speed_up);
    state.speed_mps *= speed_up;
    return SensorPose(*shared_world, drive->curve, state, sway, since);
  };
  return lap;
}

std::vector<Motion> MakeWalks(const World& world, int count, double seconds, uint64_t seed) {
  World ways = *WithoutMesh(world);
  ways.max_speed_mps = 1.3;
  ways.lane_m += 0.3;
  std::vector<Motion> walks;
  for (int i = 0; i < count; ++i) {
    Random random(seed, 0x73, static_cast<uint64_t>(i));
    if (Motion walk = MakeStroll(ways, 0, seconds, random)) walks.push_back(std::move(walk));
  }
  return walks;
}

std::vector<Motion> MakeTraffic(const World& world, int count, double seconds, uint64_t seed) {
  constexpr double kToTheRightM = 2.2;
  World streets = *WithoutMesh(world);
  streets.lane_m = 0;
  std::vector<Motion> cars;
  for (int i = 0; i < count; ++i) {
    Random random(seed, 0x74, static_cast<uint64_t>(i));
    streets.max_speed_mps = random.Uniform(3, 8);
    if (Motion car = MakeStroll(streets, kToTheRightM, seconds, random)) {
      cars.push_back(std::move(car));
    }
  }
  return cars;
}

std::vector<Motion> MakeParked(const World& world, int count, double seconds, uint64_t seed) {
  constexpr double kToTheRightM = 2.8, kBelowM = 1000;
  World streets = *WithoutMesh(world);
  streets.lane_m = 0;
  std::vector<Motion> cars;
  for (int i = 0; i < count; ++i) {
    Random random(seed, 0x75, static_cast<uint64_t>(i));
    const Motion passing = MakeStroll(streets, kToTheRightM, seconds, random);
    if (!passing) continue;
    const Pose there = passing(random.Uniform(0, seconds));
    const Pose gone(there.rotation(), there.translation() - Eigen::Vector3d(0, 0, kBelowM));
    const double leaves_s = random.Uniform(0.25 * seconds, 0.75 * seconds);
    cars.emplace_back([there, gone, leaves_s](double t) { return t < leaves_s ? there : gone; });
  }
  return cars;
}

}  // namespace isthmus::simulation
