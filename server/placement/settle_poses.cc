#include "server/placement/settle_poses.h"

#include "server/placement/graph_builder.h"
#include "server/placement/initial_poses.h"

namespace isthmus::placement {

void SettlePoses(const PlacerOptions& options, const std::vector<Placement>& previous,
                 Graph* graph) {
  for (const GraphSession& session : graph->sessions) {
    const size_t first = static_cast<size_t>(session.first_node);
    const Placement* placement = FindPlacement(previous, graph->ids[first].session);
    if (placement == nullptr || placement->reference != graph->reference) continue;
    for (size_t i = first; i < first + static_cast<size_t>(session.node_count); ++i) {
      const Pose* before = FindPose(*placement, graph->ids[i].index);
      if (before == nullptr) continue;
      Pose& pose = graph->problem.poses[i];
      const Pose moved = before->Inverse() * pose;
      if (moved.translation().norm() < options.min_move_m &&
          RotationAngle(moved) < options.min_turn_rad) {
        pose = *before;
      }
    }
  }
}

Placement MakePlacement(const Session& session, const GraphSession& place, const Graph& graph) {
  Placement placement{session.tree.session, graph.component, graph.reference, {}};
  placement.submaps.reserve(session.nodes.size());
  for (size_t k = 0; k < session.nodes.size(); ++k) {
    placement.submaps.push_back(
        {session.nodes[k].index, graph.problem.poses[static_cast<size_t>(place.first_node) + k]});
  }
  placement.T_map_odom =
      placement.submaps.back().T_map_submap * session.nodes.back().T_odom_submap.Inverse();
  return placement;
}

EdgeStatus EdgeStatusOf(const Input& input, const GraphSet& set) {
  EdgeStatus edge_status;
  for (const Match& match : input.matches) {
    if (IsAccepted(match)) edge_status.matches[{match.a, match.b}].assign(match.edges.size(), true);
  }
  for (const LoopClosure& loop : input.loops) {
    if (!loop.rejected) edge_status.loops[loop.id].assign(loop.edges.size(), true);
  }
  for (const Graph& graph : set.graphs) {
    for (size_t i = graph.odometry_edges; i < graph.origins.size(); ++i) {
      const EdgeOrigin& origin = graph.origins[i];
      const bool kept = graph.problem.edges[i].weight > 0;
      if (origin.key.source == Source::kMatch) {
        const Match& match = input.matches[origin.record];
        edge_status.matches[{match.a, match.b}][origin.edge] = kept;
      } else if (origin.key.source == Source::kLoop) {
        edge_status.loops[origin.key.loop][origin.edge] = kept;
      }
    }
    for (size_t i = 0; i < graph.anchors.size(); ++i) {
      edge_status.anchors[input.anchors[graph.anchors[i]].submap] =
          graph.problem.anchors[i].weight > 0;
    }
  }
  return edge_status;
}

}  // namespace isthmus::placement
