#include "client/offline/merge/guessed_viewpoints.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

namespace isthmus::cli {
namespace {

constexpr float kCellM = 0.5f;
constexpr double kHeightM = 1;
// Anything between these heights above the floor is in a robot's way.
constexpr float kStepM = 0.3f, kHeadM = 1.6f;
constexpr size_t kMaxPlaces = 64;
// The limit for stretches of floor other than the largest.
constexpr size_t kMaxSmaller = 10;
constexpr float kMaxRiseM = 1.5f;

struct Cell {
  float floor = std::numeric_limits<float>::infinity();
  bool blocked = false;
};

// Columns of the map by their coordinates in cells.
class FloorPlan {
 public:
  explicit FloorPlan(const Cloud& points) {
    for (const Point& p : points) {
      Cell& cell = cells_[KeyOf(p)];
      cell.floor = std::min(cell.floor, p.z);
    }
    for (const Point& p : points) {
      Cell& cell = cells_[KeyOf(p)];
      const float height = p.z - cell.floor;
      cell.blocked = cell.blocked || (height > kStepM && height < kHeadM);
    }
  }

  // Places with floor all around, in order of x and y: on the largest stretch that hangs together
  // and others at about its height that are not much smaller. Leaves out table tops, the upper
  // sides of ceilings and most of what was seen through windows.
  std::vector<Eigen::Vector3d> OpenPlaces() const {
    const std::vector<std::vector<int64_t>> regions = FloorRegions();
    std::vector<int64_t> chosen;
    for (const std::vector<int64_t>& region : regions) {
      if (kMaxSmaller * region.size() < regions[0].size()) break;
      const float rise = cells_.at(region[0]).floor - cells_.at(regions[0][0]).floor;
      if (std::abs(rise) < kMaxRiseM) chosen.insert(chosen.end(), region.begin(), region.end());
    }
    std::sort(chosen.begin(), chosen.end());
    std::vector<Eigen::Vector3d> places;
    for (const int64_t key : chosen) {
      const auto [x, y] = CoordinatesOf(key);
      places.emplace_back((static_cast<double>(x) + 0.5) * kCellM,
                          (static_cast<double>(y) + 0.5) * kCellM, cells_.at(key).floor + kHeightM);
    }
    return places;
  }

 private:
  // Open cells that hang together, the largest set first.
  std::vector<std::vector<int64_t>> FloorRegions() const {
    std::vector<std::vector<int64_t>> regions;
    std::unordered_set<int64_t> seen;
    for (const int64_t key : SortedKeys()) {
      if (!IsOpen(key) || !seen.insert(key).second) continue;
      std::vector<int64_t> region = {key};
      for (size_t i = 0; i < region.size(); ++i) {
        for (const int64_t next : Around(region[i])) {
          if (IsOpen(next) && seen.insert(next).second) region.push_back(next);
        }
      }
      regions.push_back(std::move(region));
    }
    std::stable_sort(regions.begin(), regions.end(),
                     [](const auto& l, const auto& r) { return l.size() > r.size(); });
    return regions;
  }

  // Both halves offset so that keys are in order of (x, y).
  static int64_t Key(int64_t x, int64_t y) {
    return (x + (int64_t{1} << 30)) << 32 | (y + (int64_t{1} << 30));
  }
  static std::pair<int64_t, int64_t> CoordinatesOf(int64_t key) {
    return {(key >> 32) - (int64_t{1} << 30), (key & 0xffffffff) - (int64_t{1} << 30)};
  }
  static int64_t KeyOf(const Point& p) {
    const auto index = [](float v) {
      return static_cast<int64_t>(std::floor(std::clamp(v, -1e8f, 1e8f) / kCellM));
    };
    return Key(index(p.x), index(p.y));
  }

  // The cell itself and its eight neighbours.
  static std::vector<int64_t> Around(int64_t key) {
    const auto [x, y] = CoordinatesOf(key);
    std::vector<int64_t> keys;
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) keys.push_back(Key(x + dx, y + dy));
    }
    return keys;
  }

  std::vector<int64_t> SortedKeys() const {
    std::vector<int64_t> keys;
    for (const auto& [key, cell] : cells_) keys.push_back(key);
    std::sort(keys.begin(), keys.end());
    return keys;
  }

  bool IsOpen(int64_t key) const {
    const auto here = cells_.find(key);
    if (here == cells_.end()) return false;
    const std::vector<int64_t> around = Around(key);
    return std::all_of(around.begin(), around.end(), [&](int64_t neighbour) {
      const auto it = cells_.find(neighbour);
      return it != cells_.end() && !it->second.blocked &&
             std::abs(it->second.floor - here->second.floor) < kStepM;
    });
  }

  std::unordered_map<int64_t, Cell> cells_;
};

// As many of the places as are `distance_m` from each other, first come first served.
std::vector<Eigen::Vector3d> Spread(const std::vector<Eigen::Vector3d>& places, double distance_m) {
  std::vector<Eigen::Vector3d> taken;
  for (const Eigen::Vector3d& place : places) {
    const bool apart = std::none_of(taken.begin(), taken.end(), [&](const Eigen::Vector3d& t) {
      return (t - place).squaredNorm() < distance_m * distance_m;
    });
    if (apart) taken.push_back(place);
    if (taken.size() > kMaxPlaces) break;
  }
  return taken;
}

}  // namespace

Trajectory GuessViewpoints(const Cloud& points) {
  const std::vector<Eigen::Vector3d> places = FloorPlan(points).OpenPlaces();
  std::vector<Eigen::Vector3d> spread;
  double distance_m = 2;
  do {
    spread = Spread(places, distance_m);
    distance_m *= 1.3;
  } while (spread.size() > kMaxPlaces);
  Trajectory viewpoints;
  for (const Eigen::Vector3d& place : spread) {
    viewpoints.push_back({static_cast<int64_t>(viewpoints.size()), Pose(place)});
  }
  return viewpoints;
}

}  // namespace isthmus::cli
