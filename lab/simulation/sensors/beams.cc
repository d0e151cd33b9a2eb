#include "lab/simulation/sensors/beams.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace isthmus::simulation {
namespace {

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

// Dazzling light, by the cell of directions it is in.
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

}  // namespace

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

}  // namespace isthmus::simulation
