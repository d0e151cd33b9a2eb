#include "client/cli/joined.h"

#include <algorithm>
#include <deque>
#include <map>

namespace isthmus::cli {
namespace {

std::optional<uint32_t> ComponentOf(const MatchGraph& graph, const SessionId& session) {
  for (const PlacedSession& placed : graph.placements) {
    if (placed.placement.session == session) return placed.placement.component;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::vector<SessionId>> WayBetween(const MatchGraph& graph, const SessionId& a,
                                                 const SessionId& b) {
  const std::optional<uint32_t> component = ComponentOf(graph, a);
  if (!component || component != ComponentOf(graph, b)) return std::nullopt;
  std::map<SessionId, SessionId> from = {{a, a}};  // By which session each was reached.
  for (std::deque<SessionId> next = {a}; !next.empty() && !from.contains(b); next.pop_front()) {
    for (const MatchEdge& edge : graph.matches) {
      if (!edge.in_tree || (edge.match.a != next.front() && edge.match.b != next.front())) continue;
      const SessionId& other = edge.match.a == next.front() ? edge.match.b : edge.match.a;
      if (from.try_emplace(other, next.front()).second) next.push_back(other);
    }
  }
  std::vector<SessionId> between;
  if (!from.contains(b)) return between;
  for (SessionId at = from.at(b); at != a; at = from.at(at)) between.push_back(at);
  std::ranges::reverse(between);
  return between;
}

}  // namespace isthmus::cli
