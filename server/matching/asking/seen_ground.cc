#include "server/matching/asking/seen_ground.h"

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "server/matching/asking/limits.h"
#include "server/matching/prepared/limits.h"
#include "server/matching/registration/voxel_key.h"

namespace isthmus::matching {
namespace {

using Cells = absl::flat_hash_set<uint64_t>;

// Views from a little aside end a little elsewhere: that is no new ground.
void AddWithNeighbours(uint64_t key, Cells* cells) {
  const auto column = static_cast<uint32_t>(key >> 32), row = static_cast<uint32_t>(key);
  for (const uint32_t x : {column - 1, column, column + 1}) {
    for (const uint32_t y : {row - 1, row, row + 1}) cells->insert(uint64_t{x} << 32 | y);
  }
}

// Points of as many as agreement is asked of.
size_t CountDistinctive(const PreparedSubmap& submap, const DistinctiveMap& distinctive) {
  const std::vector<SurfacePoint>& points = submap.surface();
  size_t count = 0;
  for (size_t i = 0; i < points.size(); i += points.size() / kMaxAgreementPoints + 1) {
    const Eigen::Vector3d at = submap.submap().T_odom_submap * points[i].position.cast<double>();
    count += distinctive.Has(at.cast<float>());
  }
  return count;
}

// The horizontal distance up to which the view from the stop shows ground or a wall.
double SeenUpTo(const Stop& stop, double yaw, double reach_m) {
  double farthest = 0;
  for (const double elevation : {0.0, -0.05, -0.1, -0.2, -0.35}) {
    const Eigen::Vector3d level(std::cos(yaw), std::sin(yaw), std::tan(elevation));
    const Eigen::Vector3d direction = stop.T_level_sensor.rotation().inverse() * level;
    RangeImage::Interval measured;
    if (!stop.view->At(direction.cast<float>(), &measured)) continue;
    farthest = std::max(farthest, std::cos(elevation) * double{measured.shortest});
  }
  return std::min(farthest, reach_m);
}

Cells GroundFrom(const Stop& stop, double reach_m) {
  const Eigen::Vector3d& at = stop.T_level_sensor.translation();
  Cells cells;
  for (double yaw = 0; yaw < 2 * M_PI; yaw += kAskedStepRad) {
    const double reach = SeenUpTo(stop, yaw, reach_m);
    for (double r = 0; r <= reach; r += kAskedCellM) {
      cells.insert(
          CellKey(at.x() + r * std::cos(yaw), at.y() + r * std::sin(yaw), 1 / kAskedCellM));
    }
  }
  return cells;
}

double Area(size_t cells) { return static_cast<double>(cells) * kAskedCellM * kAskedCellM; }

// Stops of the other robot that can be reached, and are not where the driver has been: what the
// other saw better from there is the better sensor's, and not to be had by going there.
std::vector<bool> AreAhead(const std::vector<Stop>& stops, const EasiestWays& ways,
                           bool driver_is_b) {
  std::vector<bool> ahead(stops.size());
  for (size_t i = 0; i < stops.size(); ++i) {
    if (stops[i].of_b == driver_is_b || ways.length_m[i] > kFarthestM) continue;
    const Eigen::Vector3d& at = stops[i].T_level_sensor.translation();
    ahead[i] = std::none_of(stops.begin(), stops.end(), [&](const Stop& other) {
      return other.of_b == driver_is_b &&
             (other.T_level_sensor.translation() - at).norm() < kBeenThereM;
    });
  }
  return ahead;
}

// The evidence of a cell of each submap's ground, on average.
std::vector<Evidence> PerCell(const PreparedMap& map, const std::vector<Cells>& of_submaps,
                              bool outdoors) {
  std::vector<Evidence> per_cell(of_submaps.size());
  for (size_t k = 0; k < of_submaps.size(); ++k) {
    if (of_submaps[k].empty()) continue;
    const auto cells = static_cast<double>(of_submaps[k].size());
    per_cell[k].ground_m2 = Area(1);
    per_cell[k].distinctive =
        static_cast<double>(CountDistinctive(*map.submaps()[k], map.distinctive())) / cells;
    if (!outdoors) per_cell[k].things = static_cast<double>(map.things().CountIn(k)) / cells;
  }
  return per_cell;
}

// The sum over all cells of the stops on the way to each: down the tree of ways, and up again.
class Accounts {
 public:
  Accounts(const EasiestWays& ways, std::vector<Cells> cells, std::vector<Evidence> per_cell)
      : cells_(std::move(cells)), per_cell_(std::move(per_cell)), after_(cells_.size()) {
    for (size_t i = 0; i < cells_.size(); ++i) {
      if (ways.before[i]) after_[*ways.before[i]].push_back(i);
      if (ways.length_m[i] == 0) open_.emplace_back(i, true);
    }
  }

  std::vector<Evidence> Sum() {
    std::vector<Evidence> sums(cells_.size());
    while (!open_.empty()) {
      const auto [at, enters] = open_.back();
      if (!enters) {
        open_.pop_back();
        Change(at, -1);
        continue;
      }
      open_.back().second = false;
      Change(at, 1);
      sums[at] = sum_;
      for (const size_t next : after_[at]) open_.emplace_back(next, true);
    }
    return sums;
  }

 private:
  // A cell has the evidence of the first stop on the way that shows it.
  void Change(size_t stop, int by) {
    for (const uint64_t key : cells_[stop]) {
      int& shown = on_way_[key];
      const bool counts = shown == (by > 0 ? 0 : 1);
      shown += by;
      if (!counts) continue;
      sum_.ground_m2 += by * per_cell_[stop].ground_m2;
      sum_.distinctive += by * per_cell_[stop].distinctive;
      sum_.things += by * per_cell_[stop].things;
    }
  }

  std::vector<Cells> cells_;
  std::vector<Evidence> per_cell_;
  std::vector<std::vector<size_t>> after_;
  std::vector<std::pair<size_t, bool>> open_;  // Stops, and whether they are still to be entered.
  absl::flat_hash_map<uint64_t, int> on_way_;
  Evidence sum_;
};

}  // namespace

SharedGround MeasureSharedGround(const std::vector<Stop>& stops, const EasiestWays& ways,
                                 bool driver_is_b, const PreparedMap& other, bool outdoors) {
  const double reach_m = outdoors ? kSeenWellOutdoorsM : kSeenWellM;
  const std::vector<bool> is_ahead = AreAhead(stops, ways, driver_is_b);
  Eigen::AlignedBox3d around;
  for (size_t i = 0; i < stops.size(); ++i) {
    if (is_ahead[i]) around.extend(stops[i].T_level_sensor.translation());
  }
  Cells of_driver, of_both;
  std::vector<Cells> cells(stops.size()), of_submaps(other.submaps().size());
  for (size_t i = 0; i < stops.size(); ++i) {
    const Stop& stop = stops[i];
    if (is_ahead[i]) {
      cells[i] = GroundFrom(stop, reach_m);
      of_submaps[stop.submap].insert(cells[i].begin(), cells[i].end());
    } else if (around.exteriorDistance(stop.T_level_sensor.translation()) < 2 * reach_m &&
               (stop.of_b == driver_is_b || ways.length_m[i] <= kFarthestM)) {
      for (const uint64_t key : GroundFrom(stop, reach_m)) {
        AddWithNeighbours(key, &of_driver);
        if (stop.of_b != driver_is_b) of_both.insert(key);
      }
    }
  }
  const std::vector<Evidence> by_submap = PerCell(other, of_submaps, outdoors);
  std::vector<Evidence> per_cell(stops.size());
  for (size_t i = 0; i < stops.size(); ++i) {
    absl::erase_if(cells[i], [&](uint64_t key) {
      return of_driver.contains(key) && (of_both.insert(key), true);
    });
    if (stops[i].of_b != driver_is_b) per_cell[i] = by_submap[stops[i].submap];
  }
  SharedGround ground;
  ground.now_m2 = Area(of_both.size());
  ground.ahead = Accounts(ways, std::move(cells), std::move(per_cell)).Sum();
  return ground;
}

}  // namespace isthmus::matching
