#include "client/simulation/effects.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isthmus::simulation {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// Rays that go on behind what they hit first.
class Onward {
 public:
  Onward(std::span<const Ray> rays, const Trace& trace, std::span<Hit> hits)
      : rays_(rays), trace_(trace), hits_(hits) {}

  void Add(size_t firing, const Ray& ray) {
    firings_.push_back(firing);
    onward_.push_back(ray);
  }
  // Calls `merge` with each first hit and what was behind it.
  template <typename Merge>
  void Go(Merge merge) {
    std::vector<Hit> behind(onward_.size());
    trace_(onward_, firings_, behind);
    for (size_t i = 0; i < behind.size(); ++i) merge(hits_[firings_[i]], behind[i]);
  }
  Eigen::Vector3f End(size_t firing) const {
    return rays_[firing].origin + hits_[firing].range_m * rays_[firing].direction;
  }

 private:
  std::span<const Ray> rays_;
  const Trace& trace_;
  std::span<Hit> hits_;
  std::vector<size_t> firings_;
  std::vector<Ray> onward_;
};

// A pane sends back what meets it squarely, mirrors some and lets most pass; all but the first look
// as far as the light has come.
void ThroughGlass(const Effects& effects, std::span<const Ray> rays, const Trace& trace,
                  Random& random, std::span<Hit> hits) {
  constexpr float kSquare = 0.998f;
  Onward onward(rays, trace, hits);
  for (size_t i = 0; i < hits.size(); ++i) {
    Hit& hit = hits[i];
    if (hit.range_m < 0 || hit.material != Material::kGlass) continue;
    if (hit.cosine > kSquare) {
      hit.material = Material::kSign;  // Glares.
      continue;
    }
    // Panes mirror the more, the more slanting they are met (after Schlick, 1994).
    const double slanting = std::pow(1 - hit.cosine, 5);
    Eigen::Vector3f direction = rays[i].direction;
    if (random.Chance(effects.glass * (0.3 + 0.7 * slanting) + (1 - effects.glass) * slanting)) {
      direction -= 2 * direction.dot(hit.normal) * hit.normal;
    }
    onward.Add(i, {onward.End(i) + 0.02f * direction, direction});
  }
  onward.Go([](Hit& first, const Hit& behind) {
    // A second pane takes what is left.
    const bool seen = behind.range_m >= 0 && behind.material != Material::kGlass;
    const float range = first.range_m + 0.02f + behind.range_m;
    first = behind;
    first.range_m = seen ? range : -1;
  });
}

void ThroughFoliage(const Effects& effects, std::span<const Ray> rays, const Trace& trace,
                    Random& random, std::span<Hit> hits) {
  constexpr float kBlur = 1.5f;  // Echoes nearer than this to each other run into one.
  Onward onward(rays, trace, hits);
  for (size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].range_m < 0 || hits[i].material != Material::kLeaves) continue;
    if (!random.Chance(effects.foliage)) continue;
    onward.Add(i, {onward.End(i) + 0.01f * rays[i].direction, rays[i].direction});
  }
  onward.Go([&](Hit& first, const Hit& behind) {
    const auto share = static_cast<float>(random.Unit());
    if (behind.range_m < 0) return;
    const float by = behind.range_m + 0.01f;
    const float near = first.range_m;
    if (by > kBlur && share < 0.5f) return;  // The nearer echo is the stronger one.
    if (by > kBlur) first = behind;
    first.range_m = near + (by > kBlur ? by : share * by);
  });
}

void Bloom(const Effects& effects, const Lidar& lidar, Random& random, std::span<Hit> hits) {
  const size_t lasers = lidar.lasers, groups = hits.size() / lasers;
  const auto reach =
      static_cast<int64_t>(effects.blooming_rad / kTurn * static_cast<double>(groups));
  const std::vector<Hit> before(hits.begin(), hits.end());
  for (size_t i = 0; i < before.size(); ++i) {
    const Hit& hit = before[i];
    if (hit.range_m < 0 || hit.material != Material::kRetro || hit.cosine < 0.3f) continue;
    const Firing& firing = lidar.firings[i];
    const auto group = static_cast<int64_t>(i / lasers);
    for (int64_t by = -reach; by <= reach; ++by) {
      const auto other = static_cast<size_t>((group + by + static_cast<int64_t>(groups)) %
                                             static_cast<int64_t>(groups));
      for (size_t k = other * lasers; k < (other + 1) * lasers; ++k) {
        const float cosine = lidar.firings[k].direction.dot(firing.direction);
        const double apart = std::acos(std::clamp(cosine, -1.0f, 1.0f));
        if (k == i || apart > effects.blooming_rad) continue;
        if (!random.Chance(0.8 * (1 - apart / effects.blooming_rad))) continue;
        if (hits[k].range_m >= 0 && hits[k].range_m < hit.range_m) continue;
        hits[k] = hit;
      }
    }
  }
}

// A beam that meets an edge sees something between the near and the far side.
void MixEdges(const Effects& effects, const Lidar& lidar, Random& random, std::span<Hit> hits) {
  constexpr float kLeast = 0.15f, kMost = 3;  // Farther apart they are two echoes.
  constexpr float kNext = 0.9998f;  // Cosine of the angle between neighbours: a degree.
  const size_t next = lidar.has_rings ? lidar.lasers : 1;
  for (size_t i = 0; i + next < hits.size(); ++i) {
    Hit &a = hits[i], &b = hits[i + next];
    if (a.range_m < 0 || b.range_m < 0) continue;
    if (lidar.firings[i].direction.dot(lidar.firings[i + next].direction) < kNext) continue;
    const float apart = std::abs(a.range_m - b.range_m);
    if (apart < kLeast || apart > kMost || !random.Chance(effects.mixed)) continue;
    Hit& far = a.range_m > b.range_m ? a : b;
    far.range_m -= apart * static_cast<float>(random.Unit());
  }
}

void Veil(const Effects& effects, const Lidar& lidar, double begin_s, Random& random,
          std::span<Hit> hits) {
  // Clouds drift by: their density by azimuth, which comes round again.
  double phase[3], per_turn[3];
  for (int wave = 0; wave < 3; ++wave) {
    phase[wave] = begin_s * (0.2 + 0.3 * wave) + wave;
    per_turn[wave] = wave + 1;
  }
  for (size_t i = 0; i < hits.size(); ++i) {
    const Eigen::Vector3f& d = lidar.firings[i].direction;
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
    Hit& hit = hits[i];
    const float near = static_cast<float>(wet ? drop_m : fleck_m);
    if ((wet || dusty) && (hit.range_m < 0 || near < hit.range_m)) {
      hit = {near, 0.5f, Material::kLeaves, -d};
    } else if (lost) {
      hit.range_m = -1;
    }
  }
}

void Cover(const Effects& effects, const Lidar& lidar, std::span<Hit> hits) {
  for (size_t i = 0; i < hits.size(); ++i) {
    const Eigen::Vector3f& d = lidar.firings[i].direction;
    const double azimuth = std::atan2(d.y(), d.x()),
                 elevation = std::asin(std::clamp(d.z(), -1.0f, 1.0f));
    for (const Shade& shade : effects.shades) {
      const double off = std::remainder(azimuth - shade.azimuth, kTurn);
      if (std::abs(off) > shade.half_width || elevation > shade.highest) continue;
      hits[i] = {shade.range_m > 0 ? shade.range_m : -1, 0.7f, Material::kCloth, -d};
    }
  }
}

void LosePackets(const Effects& effects, const Lidar& lidar, Random& random, std::span<Hit> hits) {
  const size_t packet = 12 * lidar.lasers;
  for (size_t begin = 0; begin < hits.size(); begin += packet) {
    if (!random.Chance(effects.packet_loss)) continue;
    for (size_t i = begin; i < std::min(begin + packet, hits.size()); ++i) hits[i].range_m = -1;
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

std::vector<Eigen::Vector3f> TrueDirections(const Effects& effects, const Lidar& lidar,
                                            uint64_t seed) {
  Random random(seed, 0x81, 0);
  std::vector<double> up, left;
  for (size_t ring = 0; ring < Rings(lidar); ++ring) {
    up.push_back(effects.ring_angle_sigma_rad * random.Normal());
    left.push_back(effects.ring_angle_sigma_rad * random.Normal());
  }
  std::vector<Eigen::Vector3f> directions;
  for (const Firing& firing : lidar.firings) {
    if (effects.ring_angle_sigma_rad == 0) {
      directions.push_back(firing.direction);
      continue;
    }
    const Eigen::Vector3d d = firing.direction.cast<double>();
    const double azimuth = std::atan2(d.y(), d.x()) + left[firing.ring];
    const double elevation = std::asin(std::clamp(d.z(), -1.0, 1.0)) + up[firing.ring];
    directions.push_back(Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                         std::cos(elevation) * std::sin(azimuth),
                                         std::sin(elevation))
                             .cast<float>());
  }
  return directions;
}

std::vector<float> RangeOffsets(const Effects& effects, const Lidar& lidar, uint64_t seed) {
  Random random(seed, 0x82, 0);
  std::vector<float> offsets;
  for (size_t ring = 0; ring < Rings(lidar); ++ring) {
    offsets.push_back(static_cast<float>(effects.ring_range_sigma_m * random.Normal()));
  }
  return offsets;
}

double StampError(const Effects& effects, double end_s, uint64_t seed, int index) {
  Random random(seed, 0x83, static_cast<uint64_t>(index));
  return effects.stamp_jitter_s * random.Unit() * random.Unit() + effects.clock_drift * end_s;
}

void Disturb(const Effects& effects, const Lidar& lidar, std::span<const Ray> rays,
             const Trace& trace, double begin_s, Random& random, std::span<Hit> hits) {
  if (effects.glass > 0) ThroughGlass(effects, rays, trace, random, hits);
  if (effects.foliage > 0) ThroughFoliage(effects, rays, trace, random, hits);
  if (effects.blooming_rad > 0) Bloom(effects, lidar, random, hits);
  if (effects.mixed > 0) MixEdges(effects, lidar, random, hits);
  if (effects.rain > 0 || effects.dust > 0) Veil(effects, lidar, begin_s, random, hits);
  if (!effects.shades.empty()) Cover(effects, lidar, hits);
  if (effects.packet_loss > 0) LosePackets(effects, lidar, random, hits);
}

}  // namespace isthmus::simulation
