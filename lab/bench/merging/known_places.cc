#include "lab/bench/merging/known_places.h"

#include "core/geometry/angles.h"
#include "lab/simulation/random.h"

namespace isthmus::bench {
namespace {

constexpr size_t kEveryThird = 3;
constexpr double kStartDeg = 5;

}  // namespace

void AddAnchors(const KnownPlaces& known, uint64_t seed, DrivenRobot* robot) {
  simulation::Random random(seed, 0xA7, robot->submaps.size());
  const auto add = [&](const Submap& submap, double sigma_m, double sigma_z_m, double sigma_deg) {
    const ScanPose* pose = robot->FindPose(submap.keyframes.front().sequence);
    if (pose == nullptr) return;
    const double x = sigma_m * random.Normal(), y = sigma_m * random.Normal();
    const double z = sigma_z_m * random.Normal();
    const Pose turned = Pose::FromXyzRpy(0, 0, 0, 0, 0, sigma_deg * kRadPerDeg * random.Normal());
    Anchor& anchor = robot->anchors.emplace_back();
    anchor.submap = submap.id;
    anchor.T_map_submap = Pose(turned.rotation() * pose->T_world_sensor.rotation(),
                               pose->T_world_sensor.translation() + Eigen::Vector3d(x, y, z));
    anchor.sigma_xy_m = sigma_m;
    anchor.sigma_z_m = sigma_z_m;
    anchor.sigma_deg = sigma_deg;
  };
  for (size_t k = 0; k < robot->submaps.size(); ++k) {
    if (k == 0 && known.start_m > 0) {
      add(*robot->submaps[k], known.start_m, known.start_m / 2, kStartDeg);
    } else if (k % kEveryThird == 0 && known.gnss_m > 0) {
      add(*robot->submaps[k], known.gnss_m, 0, 0);
    }
  }
}

}  // namespace isthmus::bench
