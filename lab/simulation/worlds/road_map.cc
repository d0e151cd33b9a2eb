#include "lab/simulation/worlds/road_map.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

namespace isthmus::simulation {
namespace {

using Step = std::pair<int, int>;  // A stretch in the direction (from, to).

// Dijkstra over directed stretches, which is what can forbid sharp turns. Appends the nodes
// after `at.second` to `walk`. False if nothing that fulfils `done` can be reached.
bool Walk(const RoadMap& roads, Step at, const std::function<bool(Step)>& done,
          std::vector<int>& walk) {
  std::map<Step, Step> came_from;
  std::map<Step, double> best{{at, 0}};
  std::set<std::pair<double, Step>> open{{0, at}};
  while (!open.empty()) {
    const auto [distance, step] = *open.begin();
    open.erase(open.begin());
    if (done(step)) {
      std::vector<int> tail;
      for (Step s = step; s != at; s = came_from.at(s)) tail.push_back(s.second);
      walk.insert(walk.end(), tail.rbegin(), tail.rend());
      return true;
    }
    for (const int next : roads.neighbours[step.second]) {
      if (!roads.CanTurn(step.first, step.second, next)) continue;
      const Step to{step.second, next};
      const double length = distance + (roads.nodes[next] - roads.nodes[step.second]).norm();
      if (const auto known = best.find(to); known != best.end()) {
        if (known->second <= length) continue;
        open.erase({known->second, to});
      }
      best[to] = length;
      came_from[to] = step;
      open.insert({length, to});
    }
  }
  return false;
}

// The node of the cycle that is farthest from a point.
int Farthest(const RoadMap& roads, const std::vector<int>& cycle, const Eigen::Vector2d& point) {
  return *std::max_element(cycle.begin(), cycle.end(), [&](int a, int b) {
    return (roads.nodes[a] - point).norm() < (roads.nodes[b] - point).norm();
  });
}

// Goes half way around the cycle from its node walk.back().
void GoAcross(const RoadMap& roads, const std::vector<int>& cycle, Random& random,
              std::vector<int>& walk) {
  const int size = static_cast<int>(cycle.size());
  const int start =
      static_cast<int>(std::find(cycle.begin(), cycle.end(), walk.back()) - cycle.begin());
  const auto node = [&](int i) { return cycle[((start + i) % size + size) % size]; };
  int direction = random.Chance(0.5) ? 1 : -1;
  if (walk.size() > 1 && !roads.CanTurn(walk[walk.size() - 2], walk.back(), node(direction))) {
    direction = -direction;
  }
  for (int i = 1; i <= (size + 1) / 2; ++i) walk.push_back(node(direction * i));
}

}  // namespace

int RoadMap::AddNode(const Eigen::Vector2d& position, bool is_movable) {
  nodes.push_back(position);
  movable.push_back(is_movable);
  neighbours.emplace_back();
  return static_cast<int>(nodes.size()) - 1;
}

void RoadMap::Link(int a, int b) {
  if (std::count(neighbours[a].begin(), neighbours[a].end(), b) > 0) return;
  neighbours[a].push_back(b);
  neighbours[b].push_back(a);
}

int RoadMap::AddPlace(const std::vector<int>& cycle) {
  for (size_t i = 0; i < cycle.size(); ++i) Link(cycle[i], cycle[(i + 1) % cycle.size()]);
  places.push_back(cycle);
  return static_cast<int>(places.size()) - 1;
}

Eigen::Vector2d RoadMap::Center(int place) const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const int node : places[place]) sum += nodes[node];
  return sum / static_cast<double>(places[place].size());
}

bool RoadMap::CanTurn(int a, int b, int c) const {
  const Eigen::Vector2d in = nodes[b] - nodes[a], out = nodes[c] - nodes[b];
  return in.dot(out) > -0.5 * in.norm() * out.norm();
}

double RoadMap::Distance(const Eigen::Vector2d& point) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (size_t a = 0; a < nodes.size(); ++a) {
    for (const int b : neighbours[a]) {
      if (b < static_cast<int>(a)) continue;
      const Eigen::Vector2d along = nodes[b] - nodes[a];
      const double f = std::clamp((point - nodes[a]).dot(along) / along.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (point - nodes[a] - f * along).norm());
    }
  }
  return nearest;
}

std::vector<double> RoadMap::WalkingDistances(const std::vector<int>& from) const {
  std::vector<double> best(nodes.size(), std::numeric_limits<double>::infinity());
  std::set<std::pair<double, int>> open;
  for (const int place : from) {
    for (const int node : places[place]) {
      best[node] = 0;
      open.insert({0, node});
    }
  }
  while (!open.empty()) {
    const auto [distance, node] = *open.begin();
    open.erase(open.begin());
    if (distance > best[node]) continue;
    for (const int next : neighbours[node]) {
      const double length = distance + (nodes[next] - nodes[node]).norm();
      if (length >= best[next]) continue;
      best[next] = length;
      open.insert({length, next});
    }
  }
  std::vector<double> to_place;
  for (const auto& cycle : places) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const int node : cycle) nearest = std::min(nearest, best[node]);
    to_place.push_back(nearest);
  }
  return to_place;
}

ClosedWalk Tour(const RoadMap& roads, const std::vector<int>& places, Random& random) {
  std::vector<int> walk;
  for (const int place : places) {
    const std::vector<int>& cycle = roads.places[place];
    const auto on_cycle = [&](int node) {
      return std::find(cycle.begin(), cycle.end(), node) != cycle.end();
    };
    if (walk.empty()) {
      walk.push_back(places.size() > 1 ? Farthest(roads, cycle, roads.Center(places[1]))
                                       : cycle[random.Index(static_cast<int>(cycle.size()))]);
    } else if (!on_cycle(walk.back()) &&
               !Walk(
                   roads, {walk[walk.size() - 2], walk.back()},
                   [&](Step step) { return on_cycle(step.second); }, walk)) {
      return {};
    }
    GoAcross(roads, cycle, random, walk);
  }
  if (walk.size() < 2) return {};
  const size_t done = walk.size() - 1;
  const Step first{walk[0], walk[1]};
  const Step last{walk[walk.size() - 2], walk.back()};
  if (!Walk(
          roads, last, [&](Step step) { return step == first; }, walk))
    return {};
  walk.resize(walk.size() - 2);  // The first stretch again.
  return {walk, std::min(done, walk.size() - 1)};
}

std::vector<std::vector<int>> PlanTours(const RoadMap& roads, int robots, int own, int shared,
                                        Random& random) {
  const int count = static_cast<int>(roads.places.size());
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (int i = 0; i < count; ++i) middle += roads.Center(i) / count;
  std::vector<bool> taken(count, false);
  // Takes the free place of least cost; none if every cost is infinite.
  const auto take = [&](const auto& cost, std::vector<int>& places) {
    int best = -1;
    for (int i = 0; i < count; ++i) {
      if (!taken[i] && std::isfinite(cost(i)) && (best < 0 || cost(i) < cost(best))) best = i;
    }
    if (best < 0) return;
    taken[best] = true;
    places.push_back(best);
  };

  std::vector<int> common;
  take([&](int i) { return (roads.Center(i) - middle).norm(); }, common);
  while (static_cast<int>(common.size()) < std::min(shared, count)) {
    const std::vector<double> distance = roads.WalkingDistances(common);
    take([&](int i) { return distance[i] + (roads.Center(i) - middle).norm(); }, common);
  }

  const double turn = random.Uniform(0, 2 * std::numbers::pi);
  std::vector<std::vector<int>> tours(robots);
  for (int round = 0; round < own; ++round) {
    for (int robot = 0; robot < robots; ++robot) {
      const std::vector<double> distance =
          roads.WalkingDistances(round == 0 ? common : tours[robot]);
      // Near by, and towards the robot's own side of the map.
      const double side = turn + 2 * std::numbers::pi * robot / robots;
      const Eigen::Vector2d heading(std::cos(side), std::sin(side));
      take([&](int i) { return distance[i] - 0.7 * heading.dot(roads.Center(i) - middle); },
           tours[robot]);
    }
  }
  for (auto& tour : tours) {
    std::reverse(tour.begin(), tour.end());  // From far to near, then what is shared.
    tour.insert(tour.end(), common.begin(), common.end());
  }
  return tours;
}

}  // namespace isthmus::simulation
