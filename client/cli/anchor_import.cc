#include "client/cli/anchor_import.h"

#include "client/console/console.h"
#include "client/console/say.h"

namespace isthmus::cli {

std::vector<Anchor> AnchorsOf(const PoseGraphFile& file, const Anchor& like) {
  std::vector<Anchor> anchors;
  for (size_t node = 0; node < file.graph.ids.size(); ++node) {
    const auto name = file.names.find(file.graph.ids[node]);
    if (name == file.names.end()) continue;
    Anchor anchor = like;
    anchor.submap = name->second;
    anchor.T_map_submap = file.graph.problem.poses[node];
    anchors.push_back(std::move(anchor));
  }
  return anchors;
}

absl::StatusOr<AnchorSummary> PutAnchors(client::Client& client,
                                         const std::vector<Anchor>& anchors) {
  AnchorSummary summary;
  Progress progress("anchors", anchors.size());
  for (size_t i = 0; i < anchors.size(); ++i) {
    const auto anchored = client.PutAnchor(anchors[i]);
    if (anchored.ok()) {
      ++summary.anchored;
      summary.revision = anchored->revision;
    } else if (absl::IsNotFound(anchored.status())) {
      summary.unknown.push_back(anchors[i].submap);
      Warn("isthmus: left out %s: it is not in the map\n", ToString(anchors[i].submap));
    } else {
      return anchored.status();
    }
    progress.Update(i + 1);
  }
  return summary;
}

}  // namespace isthmus::cli
