#include "server/match_graph/groups.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "server/match_graph/evidence.h"
#include "server/match_graph/group_decision.h"
#include "server/match_graph/group_hypotheses.h"
#include "server/match_graph/limits.h"
#include "server/match_graph/rigid_groups.h"

namespace isthmus::match_graph {
namespace {

// Why a match is accepted.
struct Why {
  double probability = 0;
  std::vector<Step> round;  // A way round on which it lies.
};

class Settling {
 public:
  Settling(const std::vector<Node>& nodes, const GroupOptions& options, std::vector<Match>* matches)
      : options_(options),
        evidence_(CollectEvidence(nodes, options, matches)),
        rigid_groups_(evidence_.nodes),
        groups_(evidence_, rigid_groups_, options_),
        search_(evidence_, rigid_groups_, groups_, options_) {}

  void Run() {
    for (const Hypothesis& joint : evidence_.joints)
      rigid_groups_.Join(joint.a, joint.b, joint.T_a_b);
    for (;;) {
      const GroupDecision best = search_.Find();
      if (best.groups.empty()) break;
      JoinBy(best);
    }
    for (const OpenPair& pair : evidence_.pairs) {
      if (rigid_groups_.Together(pair.a, pair.b)) SettleWithin(pair);
    }
  }

 private:
  // By the most probable hypothesis that agrees with the frame.
  void SettleWithin(const OpenPair& pair) {
    for (const Hypothesis& h : pair.hypotheses) {
      // Hypotheses that joined the frames lead nowhere but back along themselves.
      const auto known = why_.find(&h);
      const Why why =
          known != why_.end() ? known->second : Why{options_.min_probability, groups_.StepsBack(h)};
      if (GoRound(why.round, options_.cycles).Agrees()) return Accept(h, why);
    }
  }

  void JoinBy(const GroupDecision& decision) {
    std::set<uint32_t> changed;
    std::vector<FrameConstraint> constraints;
    for (const GroupHypothesis* group : decision.groups) {
      constraints.push_back(group->constraint);
      changed.insert({rigid_groups_.FrameOf(group->constraint.from),
                      rigid_groups_.FrameOf(group->constraint.to)});
    }
    const std::vector<Step> round =
        constraints.size() == 3
            ? groups_.StepsRound(constraints[0], constraints[1], constraints[2])
            : groups_.StepsBack(constraints[0], *decision.groups[0]->members[1]);
    for (const FrameConstraint& constraint : constraints)
      why_[constraint.hypothesis] = {decision.probability, round};
    for (const FrameConstraint& constraint : constraints)
      rigid_groups_.Join(constraint.from, constraint.to, constraint.T_from_to);
    for (const GroupHypothesis* group : decision.groups) {
      for (const Hypothesis* member : group->members) {
        why_.try_emplace(member, Why{decision.probability, groups_.StepsBack(*member)});
      }
    }
    search_.Forget(changed);
  }

  // The sessions on the way that are not the hypothesis's.
  std::string NamesOfOthers(const Hypothesis& h, const std::vector<Step>& round) const {
    std::set<std::string> names;
    for (const Step& step : round) {
      const auto node = static_cast<size_t>(step.from - evidence_.nodes.data());
      if (node != h.a && node != h.b) names.insert(evidence_.sessions[node].value());
    }
    return absl::StrJoin(names, ", ");
  }

  void Accept(const Hypothesis& h, const Why& why) const {
    Match& match = *h.match;
    const std::string before = absl::StrCat(ToString(match.state), " ", ToString(match.reason),
                                            match.detail.empty() ? "" : ": ", match.detail);
    const Residual left = GoRound(why.round, options_.cycles);
    if (h.rival > 0) TakeRival(h.rival - 1, &match);
    match.state = MatchState::kAccepted;
    match.reason = MatchReason::kGroup;
    match.confidence = std::min(std::max(why.probability, match.confidence), kMaxConfidence);
    match.cycle_m = left.m;
    match.cycle_deg = left.deg;
    match.detail = absl::StrFormat(
        "Settled by way of %s: going round leaves %.2f m and %.1f deg where %.2f m and %.1f deg "
        "are allowed.%s By itself it was %s",
        NamesOfOthers(h, why.round), left.m, left.deg, left.max_m, left.max_deg,
        h.rival > 0 ? absl::StrFormat(" Taken is the alignment that was number %d for these two.",
                                      h.rival + 1)
                    : "",
        before);
  }

  // The match's own place among the rivals is the taken one's.
  static void TakeRival(size_t index, Match* match) {
    RivalMatch& rival = match->rivals[index];
    RivalMatch own{match->T_a_b,           match->state,       match->reason,
                   match->confidence,      match->matcher,     match->overlap,
                   match->free_space,      match->comparisons, match->shared_area_m2,
                   std::move(match->edges)};
    match->T_a_b = rival.T_a_b;
    match->confidence = rival.confidence;
    match->matcher = rival.matcher;
    match->overlap = rival.overlap;
    match->runner_up = own.free_space;
    match->free_space = rival.free_space;
    match->comparisons = rival.comparisons;
    match->shared_area_m2 = rival.shared_area_m2;
    match->edges = std::move(rival.edges);
    // These numbers are of the other alignment.
    match->inliers = -1;
    match->inlier_ratio = match->residual_m = match->observability = match->odometry_residual = -1;
    rival = std::move(own);
  }

  const GroupOptions options_;
  const Evidence evidence_;
  RigidGroups rigid_groups_;
  const GroupHypotheses groups_;
  GroupDecisionSearch search_;
  std::map<const Hypothesis*, Why> why_;  // Reasons of hypotheses that joined frames.
};

}  // namespace

void SettleGroups(const std::vector<Node>& nodes, const GroupOptions& options,
                  std::vector<Match>* matches) {
  Settling(nodes, options, matches).Run();
}

}  // namespace isthmus::match_graph
