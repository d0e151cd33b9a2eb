// Anchors made from the poses of a graph.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <vector>

#include "client/console/pose_graph_file.h"
#include "client/library/client.h"
#include "core/map/anchor.h"

namespace isthmus::cli {

// One for every vertex that the file names, where it lies there, with the sigmas and the note of
// `like`; in order of id.
std::vector<Anchor> AnchorsOf(const PoseGraphFile& file, const Anchor& like);

struct AnchorSummary {
  int anchored = 0;
  std::vector<SubmapId> unknown;  // Not in the map, or no longer; named on stderr too.
  int64_t revision = 0;           // After the last one.
};

// Puts one after the other. Any error but NotFound ends it; those put before stay.
absl::StatusOr<AnchorSummary> PutAnchors(client::Client& client,
                                         const std::vector<Anchor>& anchors);

}  // namespace isthmus::cli
