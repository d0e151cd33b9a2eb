// A pose graph on disk: a g2o file, and what its vertices are called.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <string>

#include "core/ids.h"
#include "server/pose_graph/g2o.h"

namespace isthmus::cli {

struct PoseGraphFile {
  pose_graph::G2oGraph graph;
  // The submap of each vertex, by the vertex's id in the file: from the server's lines
  // "# VERTEX 12 alice-1/7". Empty for files from elsewhere.
  std::map<int64_t, SubmapId> names;
};

// NotFound or PermissionDenied, naming the path; InvalidArgument for a file that is no pose graph,
// or has a line that begins with "# VERTEX" and goes on otherwise.
absl::StatusOr<PoseGraphFile> ReadPoseGraph(const std::string& path);

// Prints on stderr the lines of the file that are no part of its graph, with counts, and the number
// of vertices that only edges place: a line each, if any.
void SayWhatIsMissing(const std::string& path, const pose_graph::G2oGraph& graph);

// With its names.
absl::Status WritePoseGraph(const std::string& path, const PoseGraphFile& file);

// "alice-1/7"; InvalidArgument, saying what is meant, for anything else.
absl::StatusOr<SubmapId> ParseSubmapId(const std::string& text);

}  // namespace isthmus::cli
