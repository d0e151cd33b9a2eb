#include "client/offline/merge/bare_maps.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

namespace isthmus::cli {
namespace {

// The groups of maps that hang together; few enough for a list.
class Groups {
 public:
  bool AreJoined(const RobotId& a, const RobotId& b) { return Of(a) == Of(b); }
  void Join(const RobotId& a, const RobotId& b) {
    const RobotId from = Of(b), to = Of(a);
    for (auto& [robot, group] : group_) {
      if (group == from) group = to;
    }
  }

 private:
  RobotId Of(const RobotId& robot) { return group_.emplace(robot, robot).first->second; }

  std::map<RobotId, RobotId> group_;
};

// Less of the smaller map on the other is no alignment worth writing.
constexpr double kMinOverlap = 0.1;

// A rival with this share of the best one's probability is as good: of a room that is built alike
// from two sides, the only one that it was looked at on, it had two thirds.
constexpr double kRivalOdds = 0.2;

bool IsCredible(const Match& match) {
  return match.matcher != GuessSource::kNone && match.overlap >= kMinOverlap &&
         match.reason != MatchReason::kNotConverged && match.reason != MatchReason::kDegenerate;
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

// The rival that is most probable; null where there is none.
const RivalMatch* BestRival(const Match& match) {
  const auto best = std::max_element(
      match.rivals.begin(), match.rivals.end(),
      [](const RivalMatch& l, const RivalMatch& r) { return l.confidence < r.confidence; });
  return best == match.rivals.end() ? nullptr : &*best;
}

// True if a rival is too probable beside the alignment for it to be taken unchecked.
bool HasRival(const Match& match) {
  const RivalMatch* rival = BestRival(match);
  return rival != nullptr && rival->confidence >= kRivalOdds * match.confidence;
}

std::string RivalText(const Match& match) {
  const RivalMatch* rival = BestRival(match);
  if (rival == nullptr) return "; no other alignment was found";
  const Pose apart = match.T_a_b.Inverse() * rival->T_a_b;
  return absl::StrFormat("; the next one, %.1f m and %.0f deg from it, is %.1f %% probable",
                         apart.translation().norm(), RotationAngle(apart) * 180 / std::numbers::pi,
                         100 * rival->confidence);
}

std::string Found(const Match& match) {
  if (match.matcher == GuessSource::kNone) return "No alignment was found.";
  return absl::StrFormat(
             "The best alignment found: overlap %.0f %%, residual %.3f m; with guessed sensor "
             "poses it is %.1f %% probable, and %.2f %% of %d comparisons contradict it",
             100 * match.overlap, match.residual_m, 100 * match.confidence, 100 * match.free_space,
             match.comparisons) +
         RivalText(match);
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

enum class Verdict { kLeftOut, kRefused, kJoined };

std::string VerdictText(const Match& match, Verdict verdict) {
  if (match.matcher == GuessSource::kNone) return "";
  if (verdict == Verdict::kJoined) return ", accepted because of --unverified.";
  if (!IsCredible(match)) return ": too little to accept.";
  if (HasRival(match)) {
    return ". Nothing tells which of the two is right, so --unverified accepts neither: give the "
           "trajectories, or maps that show more of what differs.";
  }
  return "; --unverified would accept it.";
}

void Report(const std::vector<std::string>& files, Verdict verdict, MatchEdge* edge) {
  Match& match = edge->match;
  const bool joined = verdict == Verdict::kJoined;
  std::vector<std::string> beside;
  beside.reserve(files.size());
  for (const std::string& file : files) beside.push_back(TrajectoryBeside(file));
  match.detail =
      absl::StrCat("The sensor's poses are unknown, so free space ",
                   joined ? "was not" : "cannot be", " checked: give ", absl::StrJoin(beside, ", "),
                   ". ", Found(match), VerdictText(match, verdict));
  edge->in_tree = joined;
  match.state = joined                         ? MatchState::kAccepted
                : verdict == Verdict::kRefused ? MatchState::kAmbiguous
                                               : MatchState::kNotYet;
  match.reason = joined                         ? MatchReason::kUnverified
                 : verdict == Verdict::kRefused ? MatchReason::kAmbiguous
                                                : MatchReason::kNoPoses;
  match.free_space = match.runner_up = -1;
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

bool IsRefused(const MatchEdge& edge, const std::vector<MergeInput>& inputs) {
  return edge.match.reason == MatchReason::kAmbiguous && !BareFiles(edge, inputs).empty();
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
    const bool wanted =
        unverified && IsCredible(edge->match) && !groups.AreJoined(edge->robot_a, edge->robot_b);
    const Verdict verdict = !wanted                 ? Verdict::kLeftOut
                            : HasRival(edge->match) ? Verdict::kRefused
                                                    : Verdict::kJoined;
    const bool join = verdict == Verdict::kJoined;
    if (join) groups.Join(edge->robot_a, edge->robot_b);
    const absl::Status decided = SendDecision(
        client, *edge, join ? ManualDecisionKind::kAccept : ManualDecisionKind::kReject);
    if (!decided.ok()) return decided;
    Report(BareFiles(*edge, inputs), verdict, edge);
  }
  return edges;
}

}  // namespace isthmus::cli
