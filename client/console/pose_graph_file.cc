#include "client/console/pose_graph_file.h"

#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>

#include <sstream>
#include <vector>

#include "client/console/say.h"
#include "core/io/file_io.h"

namespace isthmus::cli {
namespace {

constexpr char kNamePrefix[] = "# VERTEX ";

absl::Status ParseName(const std::string& line, std::map<int64_t, SubmapId>& names) {
  const std::vector<std::string> words = absl::StrSplit(line, ' ', absl::SkipWhitespace());
  int64_t id = 0;
  if (words.size() == 4 && absl::SimpleAtoi(words[2], &id)) {
    const auto submap = ParseSubmapId(words[3]);
    if (submap.ok() && names.emplace(id, *submap).second) return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("\"", line, "\" does not name a vertex: \"# VERTEX 12 alice-1/7\", each once"));
}

absl::StatusOr<PoseGraphFile> Parse(const std::string& text) {
  PoseGraphFile file;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!absl::StartsWith(line, kNamePrefix)) continue;
    const absl::Status status = ParseName(line, file.names);
    if (!status.ok()) return status;
  }
  std::istringstream input(text);
  auto graph = pose_graph::ReadG2o(input);
  if (!graph.ok()) return graph.status();
  file.graph = *std::move(graph);
  return file;
}

}  // namespace

absl::StatusOr<SubmapId> ParseSubmapId(const std::string& text) {
  const std::vector<std::string> parts = absl::StrSplit(text, '/');
  uint32_t index = 0;
  if (parts.size() == 2 && !parts[0].empty() && absl::SimpleAtoi(parts[1], &index)) {
    return SubmapId{SessionId(parts[0]), index};
  }
  return absl::InvalidArgumentError(
      absl::StrCat("\"", text, "\" is no submap: name it by session and index, as alice-1/7"));
}

absl::StatusOr<PoseGraphFile> ReadPoseGraph(const std::string& path) {
  const auto text = io::ReadFile(path);
  if (!text.ok()) return text.status();
  auto file = Parse(*text);
  if (file.ok()) return file;
  return absl::Status(file.status().code(), absl::StrCat(path, ": ", file.status().message()));
}

void SayWhatIsMissing(const std::string& path, const pose_graph::G2oGraph& graph) {
  std::vector<std::string> parts;
  for (const auto& [what, count] : graph.left_out)
    parts.push_back(absl::StrCat(count, " x ", what));
  if (!parts.empty()) {
    Warn("isthmus: %s: left out: %s\n", path, absl::StrJoin(parts, ", "));
  }
  if (graph.placed_by_edges > 0) {
    Warn("isthmus: %s: vertices that the file does not place, placed by their edges: %d\n", path,
         graph.placed_by_edges);
  }
}

absl::Status WritePoseGraph(const std::string& path, const PoseGraphFile& file) {
  std::ostringstream output;
  for (const auto& [id, submap] : file.names) {
    output << kNamePrefix << id << ' ' << ToString(submap) << '\n';
  }
  const absl::Status status =
      pose_graph::WriteG2o(file.graph.problem, file.graph.ids, output, file.graph.is_planar);
  if (!status.ok()) return status;
  return io::WriteFile(path, output.str());
}

}  // namespace isthmus::cli
