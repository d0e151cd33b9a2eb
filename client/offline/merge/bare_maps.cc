#include "client/offline/merge/bare_maps.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <tuple>
#include <utility>

namespace isthmus::cli {
namespace {

// Which maps hang together; few enough for a list.
class Groups {
 public:
  bool Join(const RobotId& a, const RobotId& b) {
    const RobotId from = Of(b), to = Of(a);
    if (from == to) return false;
    for (auto& [robot, group] : group_) {
      if (group == from) group = to;
    }
    return true;
  }

 private:
  RobotId Of(const RobotId& robot) { return group_.emplace(robot, robot).first->second; }

  std::map<RobotId, RobotId> group_;
};

// Less of the smaller map on the other is no alignment worth writing.
constexpr double kMinOverlap = 0.1;

bool IsCredible(const Match& match) {
  return match.matcher != GuessSource::kNone && match.overlap >= kMinOverlap &&
         match.reason != MatchReason::kNotConverged && match.reason != MatchReason::kDegenerate;
}

std::string TrajectoryBeside(const std::string& file) {
  return std::filesystem::path(file).replace_extension(".tum").string();
}

// The files of the pair that came without poses.
std::vector<std::string> BareFiles(const MatchEdge& edge, const std::vector<MergeInput>& inputs) {
  std::vector<std::string> files;
  for (const MergeInput& input : inputs) {
    const bool of_pair = edge.robot_a.value() == input.robot || edge.robot_b.value() == input.robot;
    if (of_pair && input.viewpoints == 0) files.push_back(input.file);
  }
  return files;
}

std::string Found(const Match& match) {
  if (match.matcher == GuessSource::kNone) return "No alignment was found.";
  return absl::StrFormat("The best alignment found: overlap %.0f %%, residual %.3f m",
                         100 * match.overlap, match.residual_m);
}

// Most likely right first.
bool IsBetter(const MatchEdge* l, const MatchEdge* r) {
  const auto rank = [](const Match& m) {
    return std::make_tuple(m.state == MatchState::kAccepted, m.confidence, m.overlap);
  };
  return rank(l->match) > rank(r->match);
}

absl::Status SendDecision(client::Client& client, const MatchEdge& edge, ManualDecisionKind kind) {
  MatchDecision decision;
  decision.session_a = edge.match.a;
  decision.session_b = edge.match.b;
  decision.kind = kind;
  decision.note = "without sensor poses";
  return client.DecideMatch(decision).status();
}

void Report(const std::vector<std::string>& files, bool joined, MatchEdge* edge) {
  Match& match = edge->match;
  std::vector<std::string> beside;
  for (const std::string& file : files) beside.push_back(TrajectoryBeside(file));
  match.detail = absl::StrCat("Nothing tells where the sensor stood, so free space ",
                              joined ? "was not" : "cannot be", " checked: give ",
                              absl::StrJoin(beside, ", "), ". ", Found(match));
  if (match.matcher != GuessSource::kNone) {
    absl::StrAppend(&match.detail, joined              ? ", believed because of --unverified."
                                   : IsCredible(match) ? "; --unverified would believe it."
                                                       : ": too little to believe.");
  }
  match.state = joined ? MatchState::kAccepted : MatchState::kNotYet;
  match.reason = joined ? MatchReason::kUnverified : MatchReason::kNoPoses;
  edge->in_tree = joined;
  match.confidence = match.free_space = match.runner_up = -1;
  match.shared_area_m2 = -1;
  match.comparisons = -1;
}

}  // namespace

std::vector<std::string> WhatIsLacking(const std::vector<MergeInput>& inputs) {
  std::vector<std::string> lacking;
  for (const MergeInput& input : inputs) {
    if (input.viewpoints > 0) continue;
    lacking.push_back(absl::StrCat(
        input.file, ": no sensor poses, so free space cannot be checked; give ",
        TrajectoryBeside(input.file), ", the robot's trajectory in the frame of the map"));
  }
  return lacking;
}

absl::StatusOr<std::vector<MatchEdge>> DecideBarePairs(client::Client& client,
                                                       const MatchGraph& graph,
                                                       const std::vector<MergeInput>& inputs,
                                                       bool unverified) {
  std::vector<MatchEdge> edges = graph.matches;
  Groups groups;
  std::vector<MatchEdge*> bare;
  for (MatchEdge& edge : edges) {
    if (!BareFiles(edge, inputs).empty()) {
      bare.push_back(&edge);
    } else if (edge.match.state == MatchState::kAccepted) {
      groups.Join(edge.robot_a, edge.robot_b);
    }
  }
  std::stable_sort(bare.begin(), bare.end(), IsBetter);
  for (MatchEdge* edge : bare) {
    const bool join =
        unverified && IsCredible(edge->match) && groups.Join(edge->robot_a, edge->robot_b);
    const absl::Status decided = SendDecision(
        client, *edge, join ? ManualDecisionKind::kAccept : ManualDecisionKind::kReject);
    if (!decided.ok()) return decided;
    Report(BareFiles(*edge, inputs), join, edge);
  }
  return edges;
}

}  // namespace isthmus::cli
