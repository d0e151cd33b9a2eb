#include "client/simulation/effects.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <utility>

namespace isthmus::simulation {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// Rays that go on behind what they hit first.
class Onward {
 public:
  Onward(const CastScan& scan, const Trace& trace) : scan_(scan), trace_(trace) {}

  // From just behind where the firing's ray ended.
  void Add(size_t firing, const Eigen::Vector3f& direction) {
    const Ray& ray = scan_.rays[firing];
    const Eigen::Vector3f end = ray.origin + scan_.hits[firing].range_m * ray.direction;
    firings_.push_back(firing);
    onward_.push_back({end + kBehindM * direction, direction});
  }
  // Calls `merge` with each first hit and what was behind it.
  template <typename Merge>
  void Go(Merge merge) {
    std::vector<Hit> behind(onward_.size());
    trace_(onward_, firings_, behind);
    for (size_t i = 0; i < behind.size(); ++i) {
      if (behind[i].range_m >= 0) behind[i].range_m += kBehindM;
      merge(scan_.hits[firings_[i]], behind[i]);
    }
  }

 private:
  static constexpr float kBehindM = 0.02f;

  const CastScan& scan_;
  const Trace& trace_;
  std::vector<size_t> firings_;
  std::vector<Ray> onward_;
};

// A pane sends back what meets it squarely, mirrors some and lets most pass; all but the first look
// as far as the light has come.
void ThroughGlass(const Effects& effects, const CastScan& scan, const Trace& trace,
                  Random& random) {
  constexpr float kSquare = 0.998f;
  Onward onward(scan, trace);
  for (size_t i = 0; i < scan.hits.size(); ++i) {
    Hit& hit = scan.hits[i];
    if (hit.range_m < 0 || hit.material != Material::kGlass) continue;
    if (hit.cosine > kSquare) {
      hit.material = Material::kSign;  // Glares.
      continue;
    }
    // Panes mirror the more, the more slanting they are met (after Schlick, 1994).
    const double slanting = std::pow(1 - hit.cosine, 5);
    Eigen::Vector3f direction = scan.rays[i].direction;
    if (random.Chance(effects.glass * (0.3 + 0.7 * slanting) + (1 - effects.glass) * slanting)) {
      direction -= 2 * direction.dot(hit.normal) * hit.normal;
    }
    onward.Add(i, direction);
  }
  onward.Go([](Hit& first, const Hit& behind) {
    // A second pane takes what is left.
    const bool seen = behind.range_m >= 0 && behind.material != Material::kGlass;
    const float range = first.range_m + behind.range_m;
    first = behind;
    first.range_m = seen ? range : -1;
  });
}

void ThroughFoliage(const Effects& effects, const CastScan& scan, const Trace& trace,
                    Random& random) {
  constexpr float kBlur = 1.5f;  // Echoes nearer than this to each other run into one.
  Onward onward(scan, trace);
  for (size_t i = 0; i < scan.hits.size(); ++i) {
    const Hit& hit = scan.hits[i];
    if (hit.range_m < 0 || hit.material != Material::kLeaves) continue;
    if (random.Chance(effects.foliage)) onward.Add(i, scan.rays[i].direction);
  }
  onward.Go([&](Hit& first, const Hit& behind) {
    const auto share = static_cast<float>(random.Unit());
    if (behind.range_m < 0) return;
    const float near = first.range_m, by = behind.range_m;
    if (by > kBlur && share < 0.5f) return;  // The nearer echo is the stronger one.
    if (by > kBlur) first = behind;
    first.range_m = near + (by > kBlur ? by : share * by);
  });
}

// What dazzles, by the cell of directions it is in.
class Dazzling {
 public:
  Dazzling(const CastScan& scan, double cell_rad) : scan_(scan), cell_rad_(cell_rad) {
    for (size_t i = 0; i < scan.hits.size(); ++i) {
      const Hit& hit = scan.hits[i];
      if (hit.range_m < 0 || hit.material != Material::kRetro || hit.cosine < 0.3f) continue;
      const auto [x, y] = CellOf(scan.firings[i].direction);
      cells_[Key(x, y)].push_back(hit);
      directions_[Key(x, y)].push_back(scan.firings[i].direction);
    }
  }
  bool empty() const { return cells_.empty(); }

  // Calls `visit` with each hit within a cell's size of a direction, and how far off it is.
  template <typename Visit>
  void Near(const Eigen::Vector3f& direction, Visit visit) const {
    const auto [x, y] = CellOf(direction);
    for (int64_t dx = -1; dx <= 1; ++dx) {
      for (int64_t dy = -1; dy <= 1; ++dy) {
        const auto cell = cells_.find(Key(x + dx, y + dy));
        if (cell == cells_.end()) continue;
        const auto& directions = directions_.at(cell->first);
        for (size_t i = 0; i < directions.size(); ++i) {
          const double apart = (directions[i] - direction).norm();
          if (apart > 0 && apart < cell_rad_) visit(cell->second[i], apart);
        }
      }
    }
  }

 private:
  static int64_t Key(int64_t x, int64_t y) { return x * 100'000 + y; }
  std::pair<int64_t, int64_t> CellOf(const Eigen::Vector3f& d) const {
    return {static_cast<int64_t>(std::floor(std::atan2(d.y(), d.x()) / cell_rad_)),
            static_cast<int64_t>(std::floor(d.z() / cell_rad_))};
  }

  const CastScan& scan_;
  double cell_rad_;
  std::unordered_map<int64_t, std::vector<Hit>> cells_;
  std::unordered_map<int64_t, std::vector<Eigen::Vector3f>> directions_;
};

void Bloom(const Effects& effects, const CastScan& scan, Random& random) {
  const Dazzling dazzling(scan, effects.blooming_rad);
  if (dazzling.empty()) return;
  for (size_t i = 0; i < scan.hits.size(); ++i) {
    Hit& hit = scan.hits[i];
    dazzling.Near(scan.firings[i].direction, [&](const Hit& bright, double apart) {
      if (hit.range_m >= 0 && hit.range_m < bright.range_m) return;
      // Many bright points that are near dazzle more than one.
      if (random.Chance(0.3 * (1 - apart / effects.blooming_rad))) hit = bright;
    });
  }
}

// A beam that meets an edge sees something between the near and the far side.
void MixEdges(const Effects& effects, const CastScan& scan, Random& random) {
  constexpr float kLeast = 0.15f, kMost = 3;  // Farther apart they are two echoes.
  constexpr float kBeside = 0.999f;           // Cosine of what beams that are neighbours have.
  for (size_t i = 0; i + scan.lasers < scan.hits.size(); ++i) {
    const auto beside = [&](size_t k) {
      return scan.firings[i].direction.dot(scan.firings[k].direction) > kBeside;
    };
    const size_t next = beside(i + scan.lasers) ? i + scan.lasers : i + 1;
    Hit &a = scan.hits[i], &b = scan.hits[next];
    if (a.range_m < 0 || b.range_m < 0) continue;
    const float apart = std::abs(a.range_m - b.range_m);
    if (apart < kLeast || apart > kMost || !beside(next) || !random.Chance(effects.mixed)) continue;
    Hit& far = a.range_m > b.range_m ? a : b;
    far.range_m -= apart * static_cast<float>(random.Unit());
  }
}

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
      const double off = std::remainder(azimuth - shade.azimuth, kTurn);
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
