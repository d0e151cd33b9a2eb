#include "lab/simulation/sensors/effects.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/simulation/sensors/beams.h"

namespace isthmus::simulation {
namespace {

void Veil(const Effects& effects, const CastScan& scan, Random& random) {
  // Clouds drift by: their density by azimuth, which comes round again.
  double phase[3], per_turn[3];
  for (int wave = 0; wave < 3; ++wave) {
    phase[wave] = scan.begin_s * (0.2 + 0.3 * wave) + wave;
    per_turn[wave] = wave + 1;
  }
  for (size_t i = 0; i < scan.hits.size(); ++i) {
    const Eigen::Vector3f& d = scan.firings[i].direction;
    const double azimuth = std::atan2(d.y(), d.x());
    double cloud = -0.2;
    for (int wave = 0; wave < 3; ++wave) {
      cloud += 0.4 * std::sin(per_turn[wave] * azimuth + phase[wave]);
    }
    const double dust = effects.dust * std::clamp(cloud, 0.0, 1.0);
    const double drop_m = -4 * std::log(1 - random.Unit()),
                 fleck_m = 0.6 - 2.5 * std::log(1 - random.Unit());
    const bool wet = random.Chance(effects.rain), dusty = random.Chance(dust);
    const bool lost = random.Chance(dust);
    Hit& hit = scan.hits[i];
    const float near = static_cast<float>(wet ? drop_m : fleck_m);
    if ((wet || dusty) && (hit.range_m < 0 || near < hit.range_m)) {
      hit = {near, 0.5f, Material::kLeaves, -d};
    } else if (lost) {
      hit.range_m = -1;
    }
  }
}

void Cover(const Effects& effects, const CastScan& scan) {
  for (size_t i = 0; i < scan.hits.size(); ++i) {
    const Eigen::Vector3f& d = scan.firings[i].direction;
    const double azimuth = std::atan2(d.y(), d.x()),
                 elevation = std::asin(std::clamp(d.z(), -1.0f, 1.0f));
    for (const Shade& shade : effects.shades) {
      const double off = std::remainder(azimuth - shade.azimuth, (2 * std::numbers::pi));
      if (std::abs(off) > shade.half_width || elevation > shade.highest) continue;
      scan.hits[i] = {shade.range_m > 0 ? shade.range_m : -1, 0.7f, Material::kCloth, -d};
    }
  }
}

void LosePackets(const Effects& effects, const CastScan& scan, Random& random) {
  const size_t packet = 12 * scan.lasers, count = scan.hits.size();
  for (size_t begin = 0; begin < count; begin += packet) {
    if (!random.Chance(effects.packet_loss)) continue;
    for (size_t i = begin; i < std::min(begin + packet, count); ++i) scan.hits[i].range_m = -1;
  }
}

size_t Rings(const Lidar& lidar) {
  size_t rings = 0;
  for (const Firing& firing : lidar.firings) rings = std::max<size_t>(rings, firing.ring + 1u);
  return rings;
}

}  // namespace

bool Effects::Disturb() const {
  return rain > 0 || dust > 0 || foliage > 0 || glass > 0 || blooming_rad > 0 || mixed > 0 ||
         packet_loss > 0 || !shades.empty();
}

Miscalibration::Miscalibration(const Effects& effects, const Lidar& lidar, uint64_t seed)
    : turned_(effects.ring_angle_sigma_rad > 0), rings_(Rings(lidar)) {
  Random random(seed, 0x81, 0);
  for (Ring& ring : rings_) {
    ring.up_rad = effects.ring_angle_sigma_rad * random.Normal();
    ring.left_rad = effects.ring_angle_sigma_rad * random.Normal();
    ring.range_m = static_cast<float>(effects.ring_range_sigma_m * random.Normal());
  }
}

Eigen::Vector3f Miscalibration::Direction(const Firing& firing) const {
  if (!turned_) return firing.direction;
  const Ring& ring = rings_[firing.ring];
  const Eigen::Vector3d d = firing.direction.cast<double>();
  const double azimuth = std::atan2(d.y(), d.x()) + ring.left_rad;
  const double elevation = std::asin(std::clamp(d.z(), -1.0, 1.0)) + ring.up_rad;
  return Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                         std::cos(elevation) * std::sin(azimuth), std::sin(elevation))
      .cast<float>();
}

double StampError(const Effects& effects, double end_s, uint64_t seed, int index) {
  Random random(seed, 0x83, static_cast<uint64_t>(index));
  const double late = random.Unit();  // Twice drawn: mostly little.
  return effects.stamp_jitter_s * late * random.Unit() + effects.clock_drift * end_s;
}

void Disturb(const Effects& effects, const CastScan& scan, const Trace& trace, Random& random) {
  if (effects.glass > 0) ThroughGlass(effects, scan, trace, random);
  if (effects.foliage > 0) ThroughFoliage(effects, scan, trace, random);
  if (effects.blooming_rad > 0) Bloom(effects, scan, random);
  if (effects.mixed > 0) MixEdges(effects, scan, random);
  if (effects.rain > 0 || effects.dust > 0) Veil(effects, scan, random);
  if (!effects.shades.empty()) Cover(effects, scan);
  if (effects.packet_loss > 0) LosePackets(effects, scan, random);
}

}  // namespace isthmus::simulation
