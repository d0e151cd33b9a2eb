#include "lab/bench/merging/pair_cost.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "lab/bench/cpu_clock.h"
#include "lab/bench/merging/figures.h"
#include "lab/bench/merging/trial.h"
#include "server/matching/pairs/matcher.h"

namespace isthmus::bench {
namespace {

using matching::PreparedMap;

// A map that grows, as the server has it.
class GrowingMap {
 public:
  explicit GrowingMap(const DrivenRobot& robot) : robot_(robot) {
    map_.session = robot.session.id;
    for (const auto& submap : robot.submaps) prepared_.push_back(matching::PrepareSubmap(submap));
  }

  const PreparedMap& Take(size_t count) {
    for (size_t k = map_.submaps.size(); k < count; ++k) map_.submaps.push_back(robot_.submaps[k]);
    const auto source = [&](const auto& submap) {
      return *std::ranges::find_if(
          prepared_, [&](const auto& known) { return known->submap().id == submap->id; });
    };
    made_ = made_ ? std::make_unique<PreparedMap>(map_, *made_, source)
                  : std::make_unique<PreparedMap>(map_, source);
    return *made_;
  }

  size_t size() const { return map_.submaps.size(); }
  size_t all() const { return robot_.submaps.size(); }
  double across_m() const {
    Eigen::AlignedBox3d box;
    for (const auto& submap : robot_.submaps) box.extend(submap->T_odom_submap.translation());
    return std::max(box.sizes().x(), box.sizes().y());
  }

 private:
  const DrivenRobot& robot_;
  SessionMap map_;
  std::vector<std::shared_ptr<const matching::PreparedSubmap>> prepared_;
  std::unique_ptr<PreparedMap> made_;
};

std::string Row(const std::string& name, const std::vector<const PairCost*>& costs) {
  std::vector<double> submaps, across, first, candidates, waiting, mean;
  for (const PairCost* cost : costs) {
    submaps.push_back(static_cast<double>(cost->submaps));
    across.push_back(cost->across_m);
    first.push_back(cost->first_s);
    candidates.push_back(cost->candidates);
    waiting.insert(waiting.end(), cost->waiting_s.begin(), cost->waiting_s.end());
  }
  const double sum = std::accumulate(waiting.begin(), waiting.end(), 0.0);
  return absl::StrFormat(
      "| %s | %d | %.0f | %.0f | %.1f (%.1f) | %.0f | %.2f (%.1f) |\n", name, costs.size(),
      Median(submaps), Median(across), Median(first), Worst(first), Median(candidates),
      sum / static_cast<double>(std::max<size_t>(1, waiting.size())), Worst(waiting));
}

}  // namespace

PairCost MeasurePairCost(std::vector<DrivenRobot> robots, size_t later) {
  NameInOrder(&robots);
  GrowingMap a(robots[0]), b(robots[1]);
  const auto at_first = [&](const GrowingMap& map) {
    return map.all() > 2 * later ? map.all() - later : map.all();
  };
  matching::MatcherOptions options;
  options.min_probability = 2;  // Nothing is.
  PairCost cost;
  std::optional<matching::PairMemory> memory = matching::PairMemory();
  const auto update = [&](size_t count_a, size_t count_b) {
    const CpuClock clock;
    const PreparedMap &map_a = a.Take(count_a), &map_b = b.Take(count_b);
    matching::PairMatcher matcher(options, std::move(*memory));
    const Match match = matcher.Update(map_a, map_b);
    memory = matcher.TakeMemory();
    return std::pair(clock.Ms() / 1e3, match);
  };
  const auto [first_s, match] = update(at_first(a), at_first(b));
  cost.submaps = a.size() + b.size();
  cost.across_m = std::max(a.across_m(), b.across_m());
  cost.first_s = first_s;
  cost.candidates = match.candidates;
  cost.stages = match.stages;
  while (a.size() < a.all() || b.size() < b.all()) {
    if (a.size() < a.all()) cost.waiting_s.push_back(update(a.size() + 1, b.size()).first);
    if (b.size() < b.all()) cost.waiting_s.push_back(update(a.size(), b.size() + 1).first);
  }
  return cost;
}

std::string PairCostTable(const std::vector<PairCost>& costs) {
  std::map<std::string, std::vector<const PairCost*>> by_scenario;
  std::map<std::string, double> stages;
  for (const PairCost& cost : costs) {
    by_scenario[cost.scenario].push_back(&cost);
    for (const StageTime& stage : cost.stages) stages[stage.stage] += stage.ms;
  }
  std::string table =
      "| scenario | pairs | submaps | m across | first search s (worst) | candidates | a submap "
      "more "
      "s, mean (worst) |\n|---|---|---|---|---|---|---|\n";
  for (const auto& [name, of_scenario] : by_scenario) table += Row(name, of_scenario);
  absl::StrAppend(&table, "\n| stage | s of wall time, mean |\n|---|---|\n");
  for (const auto& [name, ms] : stages) {
    absl::StrAppendFormat(&table, "| %s | %.2f |\n", name,
                          ms / 1e3 / static_cast<double>(costs.size()));
  }
  return table;
}

}  // namespace isthmus::bench
