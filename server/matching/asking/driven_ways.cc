#include "server/matching/asking/driven_ways.h"

#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "server/matching/asking/limits.h"

namespace isthmus::matching {
namespace {

const Eigen::Vector3d& At(const Stop& stop) { return stop.T_level_sensor.translation(); }

// Something was measured well behind the other stop, and nothing nearer.
bool SeesThroughTo(const Stop& from, const Stop& to) {
  const Eigen::Vector3f there = (from.T_level_sensor.Inverse() * At(to)).cast<float>();
  RangeImage::Interval measured;
  return from.view->At(there, &measured) && measured.Compare(there.norm(), kClearM) > 0;
}

bool MayGo(const Stop& x, const Stop& y) {
  const Eigen::Vector3d apart = At(y) - At(x);
  const double reach = x.of_b == y.of_b ? kShortcutM : kCrossingM;
  if (apart.squaredNorm() > reach * reach || std::abs(apart.z()) > kMaxRiseM) return false;
  return SeesThroughTo(x, y) || SeesThroughTo(y, x);
}

}  // namespace

DrivenWays::DrivenWays(const PreparedMap& a, const PreparedMap& b, const MapPoses& poses) {
  AddStops(a, poses.a, false, a.T_level_odom());
  AddStops(b, poses.b, true, a.T_level_odom());
  LinkStops();
}

void DrivenWays::AddStops(const PreparedMap& map, const std::vector<Pose>& poses, bool of_b,
                          const Pose& T_level_a) {
  size_t views = 0;
  for (const auto& submap : map.submaps()) views += submap->views().size();
  const size_t stride = views / kMaxStops + 1;
  size_t left = views;
  for (size_t k = 0; k < map.submaps().size(); ++k) {
    for (const PreparedSubmap::View& view : map.submaps()[k]->views()) {
      // The newest is among them.
      if (--left % stride != 0) continue;
      stops_.push_back({of_b, static_cast<uint32_t>(k), view.T_submap_sensor,
                        T_level_a * poses[k] * view.T_submap_sensor, &view.image});
      newest_[of_b ? 1 : 0] = stops_.size() - 1;
    }
  }
}

void DrivenWays::LinkStops() {
  links_.resize(stops_.size());
  for (size_t i = 0; i < stops_.size(); ++i) {
    for (size_t j = i + 1; j < stops_.size(); ++j) {
      const bool driven = j == i + 1 && stops_[i].of_b == stops_[j].of_b;
      if (!driven && !MayGo(stops_[i], stops_[j])) continue;
      const double length = (At(stops_[j]) - At(stops_[i])).norm();
      links_[i].push_back({j, length, driven});
      links_[j].push_back({i, length, driven});
    }
  }
}

EasiestWays DrivenWays::From(size_t stop) const {
  EasiestWays ways;
  ways.before.resize(stops_.size());
  ways.length_m.assign(stops_.size(), std::numeric_limits<double>::infinity());
  ways.length_m[stop] = 0;
  std::vector<double> cost = ways.length_m;
  using Reached = std::pair<double, size_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next;
  next.emplace(0, stop);
  while (!next.empty()) {
    const auto [so_far, at] = next.top();
    next.pop();
    if (so_far > cost[at]) continue;
    for (const Link& link : links_[at]) {
      const double there = so_far + link.length_m * (link.driven ? 1 : kUndriven);
      if (there >= cost[link.to]) continue;
      cost[link.to] = there;
      ways.length_m[link.to] = ways.length_m[at] + link.length_m;
      ways.before[link.to] = at;
      next.emplace(there, link.to);
    }
  }
  return ways;
}

}  // namespace isthmus::matching
