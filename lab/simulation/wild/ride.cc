#include "lab/simulation/wild/ride.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "lab/simulation/wild/faults.h"

namespace isthmus::simulation::wild {
namespace {

// People come no nearer to the robot than `distance_m`; the nearer, the more they give way.
Motion GivingWay(Motion walk, Motion robot, double distance_m) {
  return [=](double t) {
    const Pose at = walk(t);
    const Eigen::Vector2d robot_at = robot(t).translation().head<2>();
    const Eigen::Vector2d off = at.translation().head<2>() - robot_at;
    const double apart = std::max(off.norm(), 1e-6);
    const Eigen::Vector2d moved = robot_at + std::hypot(apart, distance_m) / apart * off;
    return Pose(at.rotation(), {moved.x(), moved.y(), at.translation().z()});
  };
}

// Kerbs that are driven up and down again, humps, sills: too low to be seen as more than noise.
void AddBumps(const Carrier& carrier, Path* path, Random& random) {
  const bool wheels = carrier.gait == Gait::kWheels || carrier.gait == Gait::kCar;
  const double every = random.Uniform(5, 80);
  const double highest = random.Uniform(0.02, 0.12) * std::min(1.0, 1.5 / carrier.speed_mps);
  if (!wheels || random.Chance(0.5)) return;
  for (double s = every; s + 10 < path->length(); s += every * random.Uniform(0.3, 1.7)) {
    const double length = 2 * carrier.base_m + (random.Chance(0.5) ? 0 : random.Uniform(0, 5));
    path->Raise(s, s + length, highest * random.Unit(), carrier.base_m);
  }
}

std::string Describe(const Carrier& carrier, const Faults& faults) {
  const Eigen::Vector3d up = carrier.T_base_sensor.rotation() * Eigen::Vector3d::UnitZ();
  const double tilt = std::acos(std::clamp(up.z(), -1.0, 1.0)) * 180 / std::numbers::pi;
  return absl::StrFormat("%.1f m/s, sensor at %.1f m, %.0f deg%s", carrier.speed_mps,
                         carrier.height_m, tilt, faults.about);
}

// The ride with all that it goes on to, and its length in time.
LongerMotion RideOn(const Ride& ride, const Path& path, const Timetable& timetable,
                    const Mesh& mesh, CarrierMotion* motion) {
  LongerMotion longer{motion->base, ride.seconds};
  if (ride.further.empty()) return longer;
  const RayCaster world(mesh);
  for (size_t i = 0; i < ride.further.size(); ++i) {
    const Further& further = ride.further[i];
    const double from_s = further.after_scans * ride.lidar.period_s;
    const double rest_s = from_s + BrakingSeconds(longer.base, from_s) / 2;
    Random random(ride.seed, 0x9E, i);
    longer = GoOn(
        longer.base, from_s,
        further.way.empty() ? ToAndFro(path, timetable.At(rest_s).s, further.along_m) : further.way,
        ride.carrier, world, random);
    // The state looks a little ahead, so what came before keeps its own.
    motion->sensor = [=, before = motion->sensor, base = longer.base,
                      shaken = motion->shaken](double t) {
      return t <= from_s + kTickS ? before(t) : shaken(base(t), StateOf(base, t), t);
    };
  }
  motion->base = longer.base;
  return longer;
}

}  // namespace

Ridden MakeRide(const std::string& world, Scene scene, Ride ride, Random& ride_random,
                Random& fault_random) {
  const auto path =
      std::make_shared<Path>((ride.way.backwards ? scene.path->Backwards() : *scene.path)
                                 .Moved(ride.way.left_m, ride.way.above_m));
  AddBumps(ride.carrier, path.get(), ride_random);
  const auto timetable = std::make_shared<const Timetable>(*path, ride.carrier, ride.way.begin_m,
                                                           ride.seconds, ride_random);
  CarrierMotion motion = CarrySensor(path, timetable, ride.carrier, ride_random);
  const LongerMotion longer = RideOn(ride, *path, *timetable, scene.mesh, &motion);
  Actors actors{{}, std::move(scene.cars)};
  for (Motion& walk : scene.walks) {
    actors.walks.push_back(GivingWay(std::move(walk), motion.base, scene.give_way_m));
  }
  const Faults faults = DrawFaults(ride.carrier, fault_random);
  World made;
  made.name = world;
  made.mesh = std::move(scene.mesh);
  const Options simulated{.world = world,
                          .sensor = ride.lidar.name,
                          .robots = 1,
                          .seconds = longer.end_s,
                          .seed = ride.seed,
                          .noise = faults.noise,
                          .effects = faults.effects,
                          .truth = ride.truth};
  return {std::make_unique<Simulator>(std::move(made), std::vector<Motion>{motion.sensor},
                                      std::move(actors), std::move(ride.lidar), simulated),
          Describe(ride.carrier, faults), longer.metres, longer.blocked};
}

}  // namespace isthmus::simulation::wild
