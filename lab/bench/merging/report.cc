#include "lab/bench/merging/report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "lab/bench/merging/figures.h"

namespace isthmus::bench {
namespace {

double StagesMs(const Match& match) {
  double ms = 0;
  for (const StageTime& stage : match.stages) ms += stage.ms;
  return ms;
}

// All pairs of a scenario.
struct Group {
  std::string name;
  size_t robots = 2;
  std::vector<const Trial*> trials;
  std::vector<const PairResult*> pairs;

  std::vector<double> Of(bool right_only,
                         const std::function<double(const PairResult&)>& value) const {
    std::vector<double> values;
    for (const PairResult* pair : pairs) {
      if (!right_only || pair->outcome == TrialOutcome::kRight) values.push_back(value(*pair));
    }
    return values;
  }
  int Count(TrialOutcome outcome) const {
    return static_cast<int>(std::count_if(pairs.begin(), pairs.end(), [&](const PairResult* pair) {
      return pair->outcome == outcome;
    }));
  }
};

// In order of appearance.
std::vector<Group> ByScenario(const std::vector<Trial>& trials) {
  std::vector<Group> groups;
  for (const Trial& trial : trials) {
    auto it = std::find_if(groups.begin(), groups.end(),
                           [&](const Group& group) { return group.name == trial.scenario; });
    if (it == groups.end()) it = groups.insert(groups.end(), Group{trial.scenario, 2, {}, {}});
    it->trials.push_back(&trial);
    for (const PairResult& pair : trial.pairs) {
      it->pairs.push_back(&pair);
      it->robots = std::max<size_t>(it->robots, pair.b + 1);
    }
  }
  return groups;
}

// "1 AMBIGUOUS, 2 NOT_YET LOW_OVERLAP": why pairs were not merged.
std::string Reasons(const Group& group) {
  std::map<std::string, int> counts;
  for (const PairResult* pair : group.pairs) {
    if (pair->outcome != TrialOutcome::kNotMerged) continue;
    const std::string state = ToString(pair->match.state);
    const bool twice = state == ToString(pair->match.reason);
    ++counts[twice ? state : absl::StrCat(state, " ", ToString(pair->match.reason))];
  }
  std::string text;
  for (const auto& [reason, count] : counts) {
    absl::StrAppend(&text, text.empty() ? "" : ", ", count, " ", reason);
  }
  return text.empty() ? "–" : text;
}

// "birds_eye 812, gicp 300": medians.
std::string Stages(const Group& group) {
  std::vector<std::pair<std::string, std::vector<double>>> stages;
  for (const PairResult* pair : group.pairs) {
    for (const StageTime& stage : pair->match.stages) {
      auto it = std::find_if(stages.begin(), stages.end(),
                             [&](const auto& known) { return known.first == stage.stage; });
      if (it == stages.end()) it = stages.insert(it, {stage.stage, {}});
      it->second.push_back(stage.ms);
    }
  }
  std::string text;
  for (const auto& [stage, ms] : stages) {
    absl::StrAppendFormat(&text, "%s%s %.0f", text.empty() ? "" : ", ", stage, Median(ms));
  }
  return text.empty() ? "–" : text;
}

std::string Row(const Group& group) {
  std::vector<double> cpu;
  for (const Trial* trial : group.trials) cpu.push_back(trial->cpu_ms);
  const auto overlap = group.Of(false, [](const PairResult& p) { return p.overlap; });
  const auto metres = group.Of(true, [](const PairResult& p) { return p.map.median_m; });
  const auto degrees = group.Of(true, [](const PairResult& p) { return p.map.median_deg; });
  const auto edges_m = group.Of(true, [](const PairResult& p) { return p.edges.median_m; });
  const auto edges_deg = group.Of(true, [](const PairResult& p) { return p.edges.median_deg; });
  const auto start_m = group.Of(true, [](const PairResult& p) { return p.start.median_m; });
  const auto start_deg = group.Of(true, [](const PairResult& p) { return p.start.median_deg; });
  const auto total = group.Of(false, [](const PairResult& p) { return StagesMs(p.match); });
  const auto tried =
      group.Of(false, [](const PairResult& p) { return static_cast<double>(p.match.candidates); });
  std::string row =
      absl::StrFormat("| %s | %d | %.2f-%.2f | %d | %s | %d ", group.name, group.pairs.size(),
                      Least(overlap), Worst(overlap), group.Count(TrialOutcome::kRight),
                      Reasons(group), group.Count(TrialOutcome::kWrong));
  if (metres.empty()) {
    absl::StrAppend(&row, "| – | – | – ");
  } else {
    absl::StrAppendFormat(&row, "| %.3f, %.2f (%.3f, %.2f) | %.3f, %.2f | %.3f, %.2f ",
                          Median(metres), Median(degrees), Worst(metres), Worst(degrees),
                          Median(edges_m), Median(edges_deg), Median(start_m), Median(start_deg));
  }
  absl::StrAppendFormat(&row, "| %s | %.0f (%.0f) | %.0f (%.0f) | %.0f |\n", Stages(group),
                        Median(total), Worst(total), Median(cpu), Worst(cpu), Median(tried));
  return row;
}

const char* NameOf(TrialOutcome outcome) {
  switch (outcome) {
    case TrialOutcome::kRight:
      return "right";
    case TrialOutcome::kNotMerged:
      return "not merged";
    case TrialOutcome::kWrong:
      return "WRONG";
  }
  return "";
}

nlohmann::ordered_json ToJson(const MapError& error) {
  return {{"m", error.median_m}, {"deg", error.median_deg}};
}

nlohmann::ordered_json ToJson(const PairResult& pair) {
  const Match& match = pair.match;
  nlohmann::ordered_json json = {{"a", pair.a},
                                 {"b", pair.b},
                                 {"outcome", NameOf(pair.outcome)},
                                 {"hypothesis_right", pair.hypothesis_right},
                                 {"has_hypothesis", pair.HasHypothesis()},
                                 {"overlap_of_truth", pair.overlap},
                                 {"map", ToJson(pair.map)},
                                 {"drift", ToJson(pair.drift)},
                                 {"start", ToJson(pair.start)},
                                 {"state", ToString(match.state)},
                                 {"reason", ToString(match.reason)},
                                 {"detail", match.detail},
                                 {"confidence", match.confidence},
                                 {"overlap", match.overlap},
                                 {"inliers", match.inliers},
                                 {"inlier_ratio", match.inlier_ratio},
                                 {"residual_m", match.residual_m},
                                 {"free_space", match.free_space},
                                 {"comparisons", match.comparisons},
                                 {"runner_up", match.runner_up},
                                 {"shared_area_m2", match.shared_area_m2},
                                 {"observability", match.observability},
                                 {"odometry_residual", match.odometry_residual},
                                 {"cycle_m", match.cycle_m},
                                 {"cycle_deg", match.cycle_deg},
                                 {"candidates", match.candidates},
                                 {"matcher", ToString(match.matcher)},
                                 {"submaps_a", match.submaps_a},
                                 {"submaps_b", match.submaps_b},
                                 {"edges", match.edges.size()},
                                 {"edges_error", ToJson(pair.edges)},
                                 {"frame_wrong", pair.frame_wrong},
                                 {"rivals", nlohmann::ordered_json::array()},
                                 {"asked", nlohmann::ordered_json::array()},
                                 {"stages_ms", nlohmann::ordered_json::object()}};
  for (const AskedDrive& drive : match.asked) {
    json["asked"].push_back({{"by_b", drive.by_b},
                             {"rival", drive.rival},
                             {"length_m", drive.length_m},
                             {"confidence", drive.confidence},
                             {"points", drive.way.size()},
                             {"leaves_own", drive.leaves_own}});
  }
  for (size_t i = 0; i < match.rivals.size(); ++i) {
    const RivalMatch& rival = match.rivals[i];
    json["rivals"].push_back({{"right", pair.rivals_right[i]},
                              {"state", ToString(rival.state)},
                              {"reason", ToString(rival.reason)},
                              {"confidence", rival.confidence},
                              {"free_space", rival.free_space},
                              {"comparisons", rival.comparisons},
                              {"shared_area_m2", rival.shared_area_m2}});
  }
  for (const StageTime& stage : match.stages) {
    const double before = json["stages_ms"].value(stage.stage, 0.0);
    json["stages_ms"][stage.stage] = before + stage.ms;
  }
  return json;
}

}  // namespace

std::string TrialLines(const Trial& trial) {
  std::string lines;
  for (const PairResult& pair : trial.pairs) {
    const Match& match = pair.match;
    absl::StrAppendFormat(&lines,
                          "%s %d %d~%d: %s (%s %s, confidence %.2f), overlap %.2f, maps %.3f m "
                          "%.2f deg, start %.3f m "
                          "%.2f deg, free space %.4f / %.4f of %d, %d candidates, %.0f ms\n",
                          trial.scenario, trial.seed, pair.a, pair.b, NameOf(pair.outcome),
                          ToString(match.state), ToString(match.reason), match.confidence,
                          pair.overlap, pair.map.median_m, pair.map.median_deg, pair.start.median_m,
                          pair.start.median_deg, match.free_space, match.runner_up,
                          match.comparisons, match.candidates, StagesMs(match));
  }
  absl::StrAppendFormat(
      &lines, "  %d submaps, %d loops, odometry %.3f m, %d lost, estimation %.0f ms, cpu %.0f ms",
      trial.submaps, trial.loops, trial.odometry_m, trial.lost_scans, trial.estimation_ms,
      trial.cpu_ms);
  return lines;
}

std::string MergingTable(const std::vector<Trial>& trials) {
  std::string table =
      "| scenario | pairs | overlap | right | not merged | WRONG | map on map m, deg (worst) | "
      "edges m, deg | start frames m, deg | ms per stage | ms (worst) | CPU ms (worst) | "
      "candidates |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Group& group : ByScenario(trials)) table += Row(group);
  return table;
}

int OverlapBucket(double overlap) {
  const auto* const end = std::end(kOverlapBuckets);
  const auto* const above = std::upper_bound(std::begin(kOverlapBuckets), end, overlap);
  return std::max(0, static_cast<int>(above - std::begin(kOverlapBuckets)) - 1);
}

std::string OverlapTable(const std::vector<Trial>& trials) {
  std::map<std::string, std::map<int, std::array<int, 3>>> counts;
  for (const Trial& trial : trials) {
    for (const PairResult& pair : trial.pairs) {
      ++counts[trial.world][OverlapBucket(pair.overlap)][static_cast<int>(pair.outcome)];
    }
  }
  std::string table =
      "| world | overlap | pairs | right | not merged | WRONG |\n|---|---|---|---|---|---|\n";
  constexpr int kLast = static_cast<int>(std::size(kOverlapBuckets)) - 1;
  for (const auto& [world, buckets] : counts) {
    for (const auto& [bucket, count] : buckets) {
      const double end = bucket == kLast ? 1 : kOverlapBuckets[bucket + 1];
      absl::StrAppendFormat(&table, "| %s | %.2f-%.2f | %d | %d | %d | %d |\n", world,
                            kOverlapBuckets[bucket], end, count[0] + count[1] + count[2], count[0],
                            count[1], count[2]);
    }
  }
  return table;
}

std::string TeamTable(const std::vector<Trial>& trials) {
  std::string rows;
  for (const Group& group : ByScenario(trials)) {
    std::vector<double> rmse, odometry;
    std::vector<RobotRmse> robots;
    for (const Trial* trial : group.trials) {
      if (!trial->one_frame) continue;
      rmse.push_back(trial->team_rmse_m);
      odometry.push_back(trial->odometry_m);
      robots.insert(robots.end(), trial->robots.begin(), trial->robots.end());
    }
    if (robots.empty()) continue;
    const RobotRmse worst = *std::ranges::max_element(robots, {}, &RobotRmse::Beyond);
    absl::StrAppendFormat(
        &rows, "| %s | %d | %d | %d | %d | %.3f (%.3f) | %.3f (%.3f) | %d of %d | %.3f: %.3f |\n",
        group.name, group.robots, group.trials.size(), rmse.size(),
        group.Count(TrialOutcome::kWrong), Median(rmse), Worst(rmse), Median(odometry),
        Worst(odometry),
        std::ranges::count_if(robots, [](const RobotRmse& robot) { return robot.Beyond() > 0; }),
        robots.size(), worst.odometry_m, worst.joined_m);
  }
  if (rows.empty()) return rows;
  return "| scenario | robots | teams | all in one frame | WRONG pairs | RMSE m (worst) | worst "
         "robot's odometry m (worst) | robots beyond 1.5 times it + 1 cm | worst of them: "
         "odometry, "
         "in the frame m |\n"
         "|---|---|---|---|---|---|---|---|---|\n" +
         rows;
}

nlohmann::ordered_json ToJson(const Trial& trial) {
  nlohmann::ordered_json json = {{"scenario", trial.scenario},
                                 {"world", trial.world},
                                 {"seed", trial.seed},
                                 {"submaps", trial.submaps},
                                 {"lost_scans", trial.lost_scans},
                                 {"odometry_rmse_m", trial.odometry_m},
                                 {"estimation_ms", trial.estimation_ms},
                                 {"cpu_ms", trial.cpu_ms},
                                 {"one_frame", trial.one_frame},
                                 {"team_rmse_m", trial.team_rmse_m},
                                 {"sharpness", ToJson(trial.sharpness)},
                                 {"frames", trial.frames},
                                 {"robots", nlohmann::ordered_json::array()},
                                 {"pairs", nlohmann::ordered_json::array()}};
  for (const PairResult& pair : trial.pairs) json["pairs"].push_back(ToJson(pair));
  for (const RobotRmse& robot : trial.robots) {
    json["robots"].push_back(
        {{"odometry_m", robot.odometry_m}, {"bent_m", robot.bent_m}, {"joined_m", robot.joined_m}});
  }
  return json;
}

}  // namespace isthmus::bench
