#include "lab/simulation/wild/carrier.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/geometry/angles.h"

namespace isthmus::simulation::wild {
namespace {

struct Range {
  double low, high;
  double Draw(Random& random) const { return random.Uniform(low, high); }
};

struct Habits {
  Range speed_mps, height_m, acceleration_mps2, lateral_mps2, yaw_rate_radps, base_m;
  double under_way;  // Probability.
};

Habits HabitsOf(Gait gait) {
  switch (gait) {
    case Gait::kWheels:
      return {{0.5, 4}, {0.25, 1.4}, {0.4, 3}, {0.6, 2}, {0.5, 1.8}, {0.35, 1}, 0.15};
    case Gait::kLegs:
      return {{0.4, 2.2}, {0.45, 1}, {0.5, 2}, {0.6, 1.5}, {0.6, 1.6}, {0.4, 0.8}, 0.15};
    case Gait::kHand:
      return {{0.5, 1.8}, {0.9, 2.2}, {0.6, 2}, {0.8, 1.5}, {0.8, 2}, {0.4, 0.6}, 0.15};
    case Gait::kCar:
      return {{4, 15}, {1.5, 2.2}, {1, 4}, {1, 3}, {0.3, 0.7}, {1.8, 2.8}, 0.4};
  }
  return {};
}

// The mounting of the sensor: level, or at a tilt of up to 20 degrees to any side.
Pose Mounting(double height_m, Gait gait, Random& random) {
  const double side = random.Uniform(0, 2 * std::numbers::pi);
  const double tilt =
      (random.Chance(0.4) ? random.Uniform(0, 2) : random.Uniform(0, 20)) * kRadPerDeg;
  const double yaw =
      random.Chance(0.6) ? 0.02 * random.Normal() : random.Uniform(0, 2 * std::numbers::pi);
  const double ahead = gait == Gait::kCar ? random.Uniform(-1, 1) : random.Uniform(-0.2, 0.2);
  const Eigen::Vector3d axis(std::cos(side), std::sin(side), 0);
  return Pose(Eigen::AngleAxisd(tilt, axis) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()),
              {ahead, 0.1 * random.Normal(), height_m});
}

}  // namespace

std::string NameOf(Gait gait) {
  switch (gait) {
    case Gait::kWheels:
      return "wheels";
    case Gait::kLegs:
      return "legs";
    case Gait::kHand:
      return "hand";
    case Gait::kCar:
      return "car";
  }
  return "";
}

Carrier Carrier::Draw(const std::vector<Gait>& gaits, double top_mps, Random& random) {
  Carrier carrier;
  carrier.gait = gaits[random.Index(static_cast<int>(gaits.size()))];
  const Habits habits = HabitsOf(carrier.gait);
  const double top = std::min(top_mps, habits.speed_mps.high);
  carrier.speed_mps = random.Uniform(std::min(habits.speed_mps.low, top), top);
  carrier.acceleration_mps2 = habits.acceleration_mps2.Draw(random);
  carrier.braking_mps2 = habits.acceleration_mps2.Draw(random);
  carrier.lateral_mps2 = habits.lateral_mps2.Draw(random);
  carrier.yaw_rate_radps = habits.yaw_rate_radps.Draw(random);
  carrier.under_way = random.Chance(habits.under_way);
  carrier.stop_every_m = carrier.speed_mps * random.Uniform(10, 120);
  carrier.base_m = habits.base_m.Draw(random);
  carrier.height_m = habits.height_m.Draw(random);
  carrier.T_base_sensor = Mounting(carrier.height_m, carrier.gait, random);
  return carrier;
}

}  // namespace isthmus::simulation::wild
