#include "server/matching/pairs/own_edges.h"

#include <algorithm>

namespace isthmus::matching {
namespace {

Range SpanOf(const pose_graph::Edge& edge) {
  return {static_cast<size_t>(std::min(edge.a, edge.b)),
          static_cast<size_t>(std::max(edge.a, edge.b))};
}

bool IsWithin(const Range& part, const Range& range) {
  return part.first >= range.first && part.last <= range.last;
}

}  // namespace

OwnEdges::OwnEdges(const PreparedMap& map)
    : best(map.shape() ? map.shape()->best : std::vector<Pose>()),
      edges(map.shape() ? map.shape()->edges : OdometrySteps(map.session_map().submaps)) {}

Range Close(const OwnEdges& own, Range range) {
  for (bool grown = true; grown;) {
    grown = false;
    for (const pose_graph::Edge& edge : own.edges) {
      const Range span = SpanOf(edge);
      const bool overlaps = span.first < range.last && span.last > range.first;
      if (!overlaps || IsWithin(span, range)) continue;
      range = {std::min(range.first, span.first), std::max(range.last, span.last)};
      grown = true;
    }
  }
  return range;
}

double AddOwnEdges(const OwnEdges& own, const Range& range, int first_node,
                   std::vector<pose_graph::Edge>* edges) {
  pose_graph::Problem alone;
  alone.poses = own.best;
  double chi2 = 0;
  const int shift = first_node - static_cast<int>(range.first);
  for (pose_graph::Edge edge : own.edges) {
    if (!IsWithin(SpanOf(edge), range)) continue;
    if (!own.best.empty()) chi2 += pose_graph::Chi2(alone, edge);
    edge.a += shift;
    edge.b += shift;
    edges->push_back(edge);
  }
  return chi2;
}

}  // namespace isthmus::matching
