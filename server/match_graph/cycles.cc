#include "server/match_graph/cycles.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "core/union_find.h"
#include "server/match_graph/cycle_search.h"
#include "server/match_graph/evidence.h"
#include "server/match_graph/limits.h"

namespace isthmus::match_graph {
namespace {

// The sessions and accepted matches as a graph with an order of its own.
struct Graph {
  std::vector<SessionId> sessions;  // Sorted.
  std::vector<const Node*> given;   // By node.
  std::vector<CycleNode> nodes;
  std::vector<CycleEdge> edges;  // In order of their nodes.
  std::vector<Match*> matches;   // By edge.
};

std::map<SessionId, uint32_t> AddNodes(const std::vector<Node>& given, Graph* graph) {
  std::map<SessionId, const Node*> sorted;
  for (const Node& node : given) sorted.emplace(node.session, &node);
  std::map<SessionId, uint32_t> index;
  for (const auto& [session, node] : sorted) {
    index[session] = static_cast<uint32_t>(graph->nodes.size());
    graph->sessions.push_back(session);
    graph->given.push_back(node);
    graph->nodes.push_back({node->center, node->extent_m});
  }
  return index;
}

// The more confident of two matches of a pair is the edge.
void AddEdges(const std::map<SessionId, uint32_t>& index, std::vector<Match>* matches,
              Graph* graph) {
  std::map<std::pair<uint32_t, uint32_t>, Match*> sorted;
  for (Match& match : *matches) {
    const auto a = index.find(match.a), b = index.find(match.b);
    if (!MayCarry(match) || a == index.end() || b == index.end() || a == b) continue;
    Match*& edge = sorted[std::minmax(a->second, b->second)];
    if (edge == nullptr || match.confidence > edge->confidence) edge = &match;
  }
  for (const auto& [pair, match] : sorted) {
    const bool ascending = index.at(match->a) == pair.first;
    graph->edges.push_back({pair.first, pair.second,
                            ascending ? match->T_a_b : match->T_a_b.Inverse(), match->confidence});
    graph->matches.push_back(match);
  }
}

struct Support {
  uint32_t agreeing = 0, disagreeing = 0;
  double Share() const { return agreeing / static_cast<double>(agreeing + disagreeing); }
};

// The edges to be set aside next, and why.
struct InconsistentEdges {
  std::vector<uint32_t> edges;
  std::string why;
};

class CycleCheck {
 public:
  CycleCheck(const Graph& graph, const CycleOptions& options)
      : graph_(graph),
        options_(options),
        search_(graph.nodes, graph.edges, options),
        active_(graph.edges.size(), true) {}

  void Run() {
    for (;;) {
      cycles_ = search_.Find(active_);
      NoteBest();
      WeighEdges();
      const InconsistentEdges inconsistent = FindInconsistent();
      if (inconsistent.edges.empty()) return;
      for (const uint32_t e : inconsistent.edges) active_[e] = false;
      for (const uint32_t e : inconsistent.edges) SetAside(e, inconsistent.why);
    }
  }

 private:
  bool ByHand(uint32_t e) const { return graph_.matches[e]->reason == MatchReason::kByHand; }

  double Odds(uint32_t e) const {
    const double p = std::clamp(graph_.edges[e].confidence, 1 - kMaxConfidence, kMaxConfidence);
    return p / (1 - p);
  }

  // The best cycle of every edge that is active. A match set aside keeps its last one.
  void NoteBest() {
    std::vector<const Cycle*> best(active_.size(), nullptr);
    for (const Cycle& cycle : cycles_) {
      for (const uint32_t e : cycle.edges) {
        if (best[e] == nullptr || cycle.Excess() < best[e]->Excess()) best[e] = &cycle;
      }
    }
    for (uint32_t e = 0; e < best.size(); ++e) {
      if (!active_[e]) continue;
      graph_.matches[e]->cycle_m = best[e] == nullptr ? -1 : best[e]->m;
      graph_.matches[e]->cycle_deg = best[e] == nullptr ? -1 : best[e]->deg;
    }
  }

  // The edges of a cycle that are not by hand.
  std::vector<uint32_t> Doubtful(const Cycle& cycle) const {
    std::vector<uint32_t> edges;
    for (const uint32_t e : cycle.edges) {
      if (!ByHand(e)) edges.push_back(e);
    }
    return edges;
  }

  // Weighs the cycles that count: all that agree, and those that disagree and count.
  void WeighEdges() {
    support_.assign(active_.size(), {});
    disagreeing_.clear();
    for (const Cycle& cycle : cycles_) {
      if (!cycle.Agrees()) continue;
      for (const uint32_t e : cycle.edges) ++support_[e].agreeing;
    }
    for (const Cycle& cycle : cycles_) {
      const std::vector<uint32_t> doubtful = Doubtful(cycle);
      if (cycle.Agrees() || doubtful.empty()) continue;
      // On a long way round, each step of which is borne out by others, it is drift that adds up.
      const bool borne_out = std::all_of(doubtful.begin(), doubtful.end(),
                                         [&](uint32_t e) { return support_[e].agreeing > 0; });
      if (cycle.nodes.size() > kShortCycle && borne_out) continue;
      disagreeing_.push_back(&cycle);
    }
    for (const Cycle* cycle : disagreeing_) {
      for (const uint32_t e : cycle->edges) ++support_[e].disagreeing;
    }
  }

  InconsistentEdges FindInconsistent() const {
    for (const Cycle* cycle : disagreeing_) {
      const std::vector<uint32_t> doubtful = Doubtful(*cycle);
      if (doubtful.size() == 1) return {doubtful, "all other matches of it were given by hand"};
    }
    if (disagreeing_.empty()) return {};
    return Weakest(LeastSupported());
  }

  // The edge with the smallest share of agreeing cycles, and those about as badly off that it
  // shares a disagreeing cycle with, directly or through others of them.
  std::vector<uint32_t> LeastSupported() const {
    std::vector<uint32_t> doubted;
    for (uint32_t e = 0; e < active_.size(); ++e) {
      if (support_[e].disagreeing > 0 && !ByHand(e)) doubted.push_back(e);
    }
    const uint32_t least = *std::min_element(
        doubted.begin(), doubted.end(),
        [&](uint32_t l, uint32_t r) { return support_[l].Share() < support_[r].Share(); });
    const double limit = options_.min_support * support_[least].Share();
    std::erase_if(doubted, [&](uint32_t e) { return support_[e].Share() > limit; });
    UnionFind sets(active_.size());
    for (const Cycle* cycle : disagreeing_) {
      const uint32_t* first = nullptr;
      for (const uint32_t& e : cycle->edges) {
        if (!std::binary_search(doubted.begin(), doubted.end(), e)) continue;
        if (first == nullptr) first = &e;
        sets.Unite(*first, e);
      }
    }
    std::erase_if(doubted, [&](uint32_t e) { return sets.Find(e) != sets.Find(least); });
    return doubted;
  }

  InconsistentEdges Weakest(std::vector<uint32_t> edges) const {
    if (edges.size() == 1) return OddOne(edges.front());
    std::stable_sort(edges.begin(), edges.end(),
                     [&](uint32_t l, uint32_t r) { return Odds(l) < Odds(r); });
    if (Odds(edges[1]) >= options_.min_odds * Odds(edges[0])) {
      return {{edges[0]}, "this match is by far the least certain of it"};
    }
    std::sort(edges.begin(), edges.end());
    return {edges, "nothing tells which match of it is wrong"};
  }

  std::vector<Eigen::Vector3d> GroundAt(uint32_t node, uint32_t e) const {
    const Match& match = *graph_.matches[e];
    return GroundOf(*graph_.given[node], match.edges, match.a == graph_.sessions[node]);
  }

  bool OnSameGround(uint32_t node, uint32_t e, uint32_t f) const {
    const auto p = GroundAt(node, e), q = GroundAt(node, f);
    return !p.empty() && !q.empty() && AreSameGround(p, q, options_);
  }

  // The other matches of the node that the odd one contradicts, if they may all be wrong in the
  // same way: they rest on the same ground of the node's map, on which the odd one does not.
  std::vector<uint32_t> WrongTogether(uint32_t node, uint32_t odd) const {
    std::set<uint32_t> others;
    for (const Cycle* cycle : disagreeing_) {
      if (std::find(cycle->edges.begin(), cycle->edges.end(), odd) == cycle->edges.end()) continue;
      for (const uint32_t e : cycle->edges) {
        const CycleEdge& edge = graph_.edges[e];
        if (e != odd && (edge.a == node || edge.b == node)) others.insert(e);
      }
    }
    const bool may_be =
        others.size() > 1 && std::all_of(others.begin(), others.end(), [&](uint32_t e) {
          return !ByHand(e) && !OnSameGround(node, e, odd) &&
                 OnSameGround(node, e, *others.begin());
        });
    return may_be ? std::vector<uint32_t>(others.begin(), others.end()) : std::vector<uint32_t>();
  }

  // By number the odd one is wrong. What rests on one ground counts as one, though: as in a lone
  // triangle, that goes which is by far the least certain, or else all.
  InconsistentEdges OddOne(uint32_t odd) const {
    std::vector<std::pair<double, std::vector<uint32_t>>> suspects = {{Odds(odd), {odd}}};
    for (const uint32_t node : {graph_.edges[odd].a, graph_.edges[odd].b}) {
      const std::vector<uint32_t> others = WrongTogether(node, odd);
      if (others.empty()) continue;
      double odds = 0;
      for (const uint32_t e : others) odds = std::max(odds, Odds(e));
      suspects.emplace_back(odds, others);
    }
    if (suspects.size() == 1) return {{odd}, "the other matches of it are better borne out"};
    std::stable_sort(suspects.begin(), suspects.end(),
                     [](const auto& l, const auto& r) { return l.first < r.first; });
    if (suspects[1].first >= options_.min_odds * suspects[0].first) {
      return {suspects[0].second, "what rests on this ground is by far the least certain of it"};
    }
    std::set<uint32_t> all;
    for (const auto& [odds, edges] : suspects) all.insert(edges.begin(), edges.end());
    return {{all.begin(), all.end()},
            "those that agree rest on the same ground, so that nothing tells which match of it is "
            "wrong"};
  }

  // The least bad of the shortest cycles that contradict the match.
  const Cycle& Against(uint32_t e) const {
    const Cycle* least = nullptr;
    for (const Cycle* cycle : disagreeing_) {
      if (std::find(cycle->edges.begin(), cycle->edges.end(), e) == cycle->edges.end()) continue;
      const auto rank = [](const Cycle& c) { return std::make_pair(c.nodes.size(), c.Excess()); };
      if (least == nullptr || rank(*cycle) < rank(*least)) least = cycle;
    }
    return *least;
  }

  void SetAside(uint32_t e, const std::string& why) {
    Match& match = *graph_.matches[e];
    const Cycle& cycle = Against(e);
    std::string round;
    for (const uint32_t node : cycle.nodes) {
      absl::StrAppend(&round, graph_.sessions[node].value(), ", ");
    }
    absl::StrAppend(&round, graph_.sessions[cycle.nodes.front()].value());
    match.state = MatchState::kAmbiguous;
    match.reason = MatchReason::kCycle;
    match.detail = absl::StrFormat(
        "Going round %s leaves %.2f m and %.1f deg where %.2f m and %.1f deg are allowed, and %s. "
        "By itself it was accepted: %s",
        round, cycle.m, cycle.deg, cycle.max_m, cycle.max_deg, why, match.detail);
  }

  const Graph& graph_;
  const CycleOptions options_;
  const CycleSearch search_;
  std::vector<bool> active_;
  std::vector<Cycle> cycles_;              // Cycles of active edges.
  std::vector<const Cycle*> disagreeing_;  // Disagreeing cycles that count.
  std::vector<Support> support_;           // By edge.
};

}  // namespace

void CheckCycles(const std::vector<Node>& nodes, const CycleOptions& options,
                 std::vector<Match>* matches) {
  for (Match& match : *matches) match.cycle_m = match.cycle_deg = -1;
  Graph graph;
  const std::map<SessionId, uint32_t> index = AddNodes(nodes, &graph);
  AddEdges(index, matches, &graph);
  CycleCheck(graph, options).Run();
}

}  // namespace isthmus::match_graph
