#include "server/placement/graph_text.h"

#include <algorithm>
#include <sstream>

#include "server/pose_graph/g2o.h"

namespace isthmus::placement {

absl::StatusOr<std::string> GraphText(const Graph& graph) {
  pose_graph::Problem kept = graph.problem;
  const auto discarded = [](const auto& record) { return record.weight == 0; };
  std::erase_if(kept.edges, discarded);
  std::erase_if(kept.anchors, discarded);
  std::ostringstream text;
  for (size_t i = 0; i < graph.ids.size(); ++i) {
    text << "# VERTEX " << i << ' ' << ToString(graph.ids[i]) << '\n';
  }
  const absl::Status status = pose_graph::WriteG2o(kept, {}, text);
  if (!status.ok()) return status;
  return text.str();
}

}  // namespace isthmus::placement
