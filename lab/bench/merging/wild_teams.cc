#include "lab/bench/merging/wild_teams.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <map>
#include <set>
#include <utility>

#include "core/union_find.h"
#include "lab/bench/merging/figures.h"

namespace isthmus::bench {
namespace {

constexpr std::array<double, 2> kOverlaps = {0.3, 0.15};

// Counts of the robots that hang together by pairs that overlap so much.
struct Together {
  size_t groups = 0, in_one_frame = 0;    // Groups of two robots and more.
  size_t robots = 0, in_their_frame = 0;  // In such groups; in the frame that holds most of theirs.
  bool All() const { return groups > 0 && groups == in_one_frame; }
};

Together CountTogether(const Trial& trial, double least_overlap) {
  UnionFind sets(trial.frames.size());
  for (const PairResult& pair : trial.pairs) {
    if (pair.overlap >= least_overlap) {
      sets.Unite(static_cast<size_t>(pair.a), static_cast<size_t>(pair.b));
    }
  }
  std::map<size_t, std::vector<uint32_t>> groups;  // Frames by root.
  for (size_t i = 0; i < trial.frames.size(); ++i) groups[sets.Find(i)].push_back(trial.frames[i]);
  Together together;
  for (const auto& [root, frames] : groups) {
    if (frames.size() < 2) continue;
    std::map<uint32_t, size_t> counts;
    for (const uint32_t frame : frames) ++counts[frame];
    size_t most = 0;
    for (const auto& [frame, count] : counts) most = std::max(most, count);
    ++together.groups;
    together.in_one_frame += counts.size() == 1;
    together.robots += frames.size();
    if (most > 1) together.in_their_frame += most;
  }
  return together;
}

// A row of the table.
struct TeamsTally {
  int worlds = 0, robots = 0;
  std::array<int, 2> with = {}, all = {};  // Worlds that have such robots, and have them together.
  std::array<size_t, 2> of = {}, joined = {};
  int accepted = 0, by_group = 0, wrong = 0, wrong_frames = 0;
  std::vector<double> rmse;
  std::vector<RobotRmse> in_company;

  void Add(const Trial& trial) {
    ++worlds;
    robots += static_cast<int>(trial.frames.size());
    for (size_t i = 0; i < kOverlaps.size(); ++i) {
      const Together together = CountTogether(trial, kOverlaps[i]);
      with[i] += together.groups > 0;
      all[i] += together.All();
      of[i] += together.robots;
      joined[i] += together.in_their_frame;
    }
    for (const PairResult& pair : trial.pairs) {
      accepted += pair.outcome != TrialOutcome::kNotMerged;
      by_group +=
          pair.match.state == MatchState::kAccepted && pair.match.reason == MatchReason::kGroup;
      wrong += pair.outcome == TrialOutcome::kWrong;
      wrong_frames += pair.frame_wrong;
    }
    if (trial.one_frame) rmse.push_back(trial.team_rmse_m);
    in_company.insert(in_company.end(), trial.joined.begin(), trial.joined.end());
  }
};

std::string TeamsRow(const std::string& name, const TeamsTally& t) {
  std::string row = absl::StrFormat("| %s | %d | %d |", name, t.worlds, t.robots);
  for (size_t i = 0; i < kOverlaps.size(); ++i) {
    absl::StrAppendFormat(&row, " %d of %d | %d of %d |", t.all[i], t.with[i], t.joined[i],
                          t.of[i]);
  }
  absl::StrAppendFormat(&row, " %d (%d) | %d | %d | %.3f (%.3f) | ", t.accepted, t.by_group,
                        t.wrong, t.wrong_frames, Median(t.rmse), Worst(t.rmse));
  if (t.in_company.empty()) return row + "– |\n";
  const auto bent = std::ranges::count_if(
      t.in_company, [](const RobotRmse& robot) { return robot.BentBeyond() > 0; });
  const RobotRmse worst = *std::ranges::max_element(t.in_company, {}, &RobotRmse::BentBeyond);
  absl::StrAppendFormat(&row, "%d of %d (%.3f: %.3f) |\n", bent, t.in_company.size(),
                        worst.odometry_m, worst.bent_m);
  return row;
}

}  // namespace

absl::StatusOr<std::vector<WildTeam>> DrawWildTeams(const WildPairsOptions& options) {
  const auto pairs = DrawWildPairs(options);
  if (!pairs.ok()) return pairs.status();
  std::vector<WildTeam> teams;
  for (const WildPair& pair : *pairs) {
    if (pair.relation != WildRelation::kTeam) continue;
    if (teams.empty() || teams.back().seed != pair.seed) {
      teams.push_back({pair.kind, pair.seed, {}});
    }
    std::vector<DriveOptions>& drives = teams.back().drives;
    for (const DriveOptions& drive : {pair.a, pair.b}) {
      const bool known = std::any_of(drives.begin(), drives.end(), [&](const DriveOptions& other) {
        return other.robot == drive.robot;
      });
      if (!known) drives.push_back(drive);
    }
  }
  return teams;
}

std::vector<DrivenRobot> DriveWildTeam(const WildTeam& team, DriveCache& cache) {
  std::vector<DrivenRobot> robots;
  for (const DriveOptions& drive : team.drives) {
    auto robot = cache.Get(drive);
    if (robot.ok()) {
      robots.push_back(*std::move(robot));
    } else {
      std::cerr << drive.Key() << ": " << robot.status() << std::endl;
    }
  }
  return robots;
}

std::string WildTeamsTable(const std::vector<Trial>& trials) {
  std::map<std::string, TeamsTally> kinds;
  TeamsTally all;
  for (const Trial& trial : trials) {
    kinds[trial.scenario].Add(trial);
    all.Add(trial);
  }
  std::string table =
      "| worlds | count | robots | overlap 0.3: all in one frame | robots | 0.15: all in one frame "
      "| robots | pairs accepted (by group) | WRONG pairs | WRONG in a frame | RMSE m (worst) | "
      "bent "
      "beyond 1.5 times odometry + 1 cm (worst: odometry, in the map m) |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [kind, tally] : kinds) table += TeamsRow(kind, tally);
  return table + TeamsRow("all", all);
}

}  // namespace isthmus::bench
