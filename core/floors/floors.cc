#include "core/floors/floors.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/floors/limits.h"

namespace isthmus::floors {
namespace {

struct HeightRange {
  int first = 0, last = 0;  // Bins, both included.
};

int BinOf(double height_m) { return static_cast<int>(std::floor(height_m / kFloorBinM)); }

std::vector<HeightRange> DenseRanges(const std::vector<Eigen::Vector3d>& stations) {
  std::map<int, int> counts;
  for (const Eigen::Vector3d& station : stations) ++counts[BinOf(station.z())];
  int fullest = 0;
  for (const auto& [bin, count] : counts) fullest = std::max(fullest, count);
  const int needed = std::max(kFloorStations, static_cast<int>(std::lround(kFloorShare * fullest)));
  std::vector<HeightRange> ranges;
  for (const auto& [bin, count] : counts) {
    if (count < needed) continue;
    if (!ranges.empty() && (bin - ranges.back().last - 1) * kFloorBinM < kFloorGapM) {
      ranges.back().last = bin;
    } else {
      ranges.push_back({bin, bin});
    }
  }
  return ranges;
}

void AddStation(const Eigen::Vector3d& station, Floor* floor) {
  const bool is_first = floor->stations.empty();
  floor->lowest_m = is_first ? station.z() : std::min(floor->lowest_m, station.z());
  floor->highest_m = is_first ? station.z() : std::max(floor->highest_m, station.z());
  floor->stations.push_back(station);
}

}  // namespace

void AddStations(const Trajectory& way, std::vector<Eigen::Vector3d>* stations) {
  const Eigen::Vector3d* last = nullptr;
  for (const StampedPose& pose : way) {
    const Eigen::Vector3d& at = pose.pose.translation();
    if (last != nullptr && (at - *last).norm() < kStationM) continue;
    stations->push_back(at);
    last = &at;
  }
}

std::vector<Floor> FloorsOf(const std::vector<Eigen::Vector3d>& stations) {
  if (stations.empty()) return {};
  const std::vector<HeightRange> ranges = DenseRanges(stations);
  std::vector<Floor> floors(std::max<size_t>(ranges.size(), 1));
  for (const Eigen::Vector3d& station : stations) {
    const int bin = BinOf(station.z());
    // A bin more at each end: where a floor fills two bins unevenly.
    const auto range = std::find_if(ranges.begin(), ranges.end(), [bin](const HeightRange& any) {
      return bin >= any.first - 1 && bin <= any.last + 1;
    });
    if (range != ranges.end()) {
      AddStation(station, &floors[static_cast<size_t>(range - ranges.begin())]);
    } else if (ranges.empty()) {
      AddStation(station, &floors[0]);
    }
  }
  return floors;
}

}  // namespace isthmus::floors
