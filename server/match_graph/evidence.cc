#include "server/match_graph/evidence.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "server/match_graph/limits.h"

namespace isthmus::match_graph {
namespace {

// True if others may settle what is open for this reason: that there is too little to see, or too
// much that looks alike. An alignment that slides or did not settle is no better in company.
bool MayBeSettled(MatchState state, MatchReason reason) {
  if (state != MatchState::kAmbiguous && state != MatchState::kNotYet) return false;
  switch (reason) {
    case MatchReason::kAmbiguous:
    case MatchReason::kPossibleTwin:
    case MatchReason::kCycle:
    case MatchReason::kTooSmall:
    case MatchReason::kLowOverlap:
    case MatchReason::kLoose:
    case MatchReason::kFreeSpace:
      return true;
    default:
      return false;
  }
}

double LogOdds(double confidence, double none) {
  const double p = std::clamp(confidence, 1 - kMaxConfidence, kMaxConfidence);
  return std::log(p / std::max(none, 1 - kMaxConfidence));
}

// The probability that none of what is said of a pair is right, beside one of which this is the
// confidence. Said by hand, or of a store whose confidences were not yet shares of one, they may be
// more than 1 together.
double NoneOf(const Match& match, double confidence) {
  double sum = match.confidence;
  for (const RivalMatch& rival : match.rivals) sum += rival.confidence;
  return 1 - (sum <= 1 ? sum : confidence);
}

void SortByOdds(std::vector<Hypothesis>* hypotheses) {
  std::stable_sort(
      hypotheses->begin(), hypotheses->end(),
      [](const Hypothesis& l, const Hypothesis& r) { return l.log_odds > r.log_odds; });
}

class Collector {
 public:
  Collector(const std::vector<Node>& nodes, const GroupOptions& options) : options_(options) {
    for (const Node& node : nodes) nodes_.emplace(node.session, &node);
    for (const auto& [session, node] : nodes_) {
      index_[session] = static_cast<uint32_t>(evidence_.nodes.size());
      evidence_.sessions.push_back(session);
      evidence_.nodes.push_back({node->center, node->extent_m});
    }
  }

  Evidence Collect(std::vector<Match>* matches) {
    std::map<std::pair<SessionId, SessionId>, Match*> sorted;
    for (Match& match : *matches) {
      if (!index_.contains(match.a) || !index_.contains(match.b) || match.a == match.b) continue;
      Match*& kept = sorted[std::minmax(match.a, match.b)];
      if (kept == nullptr || match.confidence > kept->confidence) kept = &match;
    }
    for (const auto& [pair, match] : sorted) AddMatch(match);
    // Both begin in order of pairs and rivals.
    SortByOdds(&evidence_.joints);
    for (OpenPair& pair : evidence_.pairs) SortByOdds(&pair.hypotheses);
    return std::move(evidence_);
  }

 private:
  void AddMatch(Match* match) {
    RivalMatch own;  // Its edges are the match's.
    own.T_a_b = match->T_a_b;
    own.state = match->state;
    own.reason = match->reason;
    own.confidence = match->confidence;
    if (MayCarry(*match)) {
      evidence_.joints.push_back(Make(match, 0, own, match->edges));
      return;
    }
    const auto [a, b] = std::minmax(index_.at(match->a), index_.at(match->b));
    evidence_.pairs.push_back({a, b, {}, {}});
    Add(match, 0, own, match->edges);
    if (match->reason == MatchReason::kByHand) return;
    for (size_t i = 0; i < match->rivals.size(); ++i) {
      Add(match, i + 1, match->rivals[i], match->rivals[i].edges);
    }
  }

  void Add(Match* match, size_t rival, const RivalMatch& said,
           const std::vector<SubmapEdge>& edges) {
    if (!said.T_a_b.IsFinite() || !std::isfinite(said.confidence)) return;
    if (said.state == MatchState::kRejected) {
      evidence_.pairs.back().contradicted.push_back(Make(match, rival, said, {}));
    } else if (MayBeSettled(said.state, said.reason) &&
               said.confidence >= options_.min_confidence) {
      evidence_.pairs.back().hypotheses.push_back(Make(match, rival, said, edges));
    }
  }

  Hypothesis Make(Match* match, size_t rival, const RivalMatch& said,
                  const std::vector<SubmapEdge>& edges) const {
    Hypothesis h{index_.at(match->a),
                 index_.at(match->b),
                 said.T_a_b,
                 LogOdds(said.confidence, NoneOf(*match, said.confidence)),
                 match,
                 rival,
                 GroundOf(*nodes_.at(match->a), edges, true),
                 GroundOf(*nodes_.at(match->b), edges, false)};
    if (h.a > h.b) {
      std::swap(h.a, h.b);
      std::swap(h.ground_a, h.ground_b);
      h.T_a_b = h.T_a_b.Inverse();
    }
    return h;
  }

  const GroupOptions options_;
  std::map<SessionId, const Node*> nodes_;
  std::map<SessionId, uint32_t> index_;
  Evidence evidence_;
};

}  // namespace

Evidence CollectEvidence(const std::vector<Node>& nodes, const GroupOptions& options,
                         std::vector<Match>* matches) {
  return Collector(nodes, options).Collect(matches);
}

bool AreSameGround(const std::vector<Eigen::Vector3d>& p, const std::vector<Eigen::Vector3d>& q,
                   const CycleOptions& options) {
  if (p.empty() || q.empty()) return true;
  const auto& fewer = p.size() <= q.size() ? p : q;
  const auto& more = p.size() <= q.size() ? q : p;
  const auto near = std::count_if(fewer.begin(), fewer.end(), [&](const Eigen::Vector3d& x) {
    return std::any_of(more.begin(), more.end(), [&](const Eigen::Vector3d& y) {
      return (x - y).norm() <= options.ground_m;
    });
  });
  return static_cast<double>(near) > options.max_same_ground * static_cast<double>(fewer.size());
}

std::vector<Eigen::Vector3d> GroundOf(const Node& node, const std::vector<SubmapEdge>& edges,
                                      bool of_a) {
  std::set<uint32_t> submaps;
  for (const SubmapEdge& edge : edges) submaps.insert(of_a ? edge.submap_a : edge.submap_b);
  std::vector<Eigen::Vector3d> ground;
  for (const uint32_t submap : submaps) {
    const auto known = node.submaps.find(submap);
    if (known != node.submaps.end()) ground.push_back(known->second);
  }
  return ground;
}

}  // namespace isthmus::match_graph
