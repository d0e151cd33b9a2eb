// Files that people bring: tokens, certificates, pose graphs, trajectories, OctoMap's trees. The
// first byte chooses.
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>

#include "core/formats/octomap_reader.h"
#include "core/formats/tum.h"
#include "core/tls/certificate.h"
#include "server/access/token_text.h"
#include "server/pose_graph/g2o.h"

namespace isthmus {
namespace {

// The checksum would stop all that is not one: the fuzzer's bytes are the lines above it.
void TryTokens(const std::string& lines) {
  (void)access::ParseTokens(lines);
  const std::string empty = access::PrintTokens({});
  const std::string head = empty.substr(0, empty.rfind("crc32c "));
  const auto tokens = access::ParseTokens(head + lines + access::SumLine(head + lines));
  if (!tokens.ok()) return;
  const std::string printed = access::PrintTokens(*tokens);
  const auto again = access::ParseTokens(printed);
  if (!again.ok() || access::PrintTokens(*again) != printed) std::abort();
}

void TryPoseGraph(const std::string& text) {
  std::istringstream input(text);
  const auto graph = pose_graph::ReadG2o(input);
  if (!graph.ok()) return;
  const auto count = static_cast<int>(graph->problem.poses.size());
  for (const Pose& pose : graph->problem.poses) {
    if (!pose.IsFinite()) std::abort();
  }
  for (const pose_graph::Edge& edge : graph->problem.edges) {
    if (edge.a < 0 || edge.a >= count || edge.b < 0 || edge.b >= count) std::abort();
    if (!edge.T_a_b.IsFinite() || !edge.information.allFinite()) std::abort();
  }
  std::ostringstream output;
  if (!pose_graph::WriteG2o(graph->problem, graph->ids, output, graph->is_planar).ok())
    std::abort();
}

void TryTrajectory(const std::string& text) {
  const auto trajectory = formats::ParseTum(text);
  if (!trajectory.ok()) return;
  for (const auto& stamped : *trajectory) {
    if (!stamped.pose.IsFinite()) std::abort();
  }
}

void TryOctomap(const std::string& bytes) {
  const auto visit = [](const VoxelCube& leaf) {
    if (leaf.edge < 1) std::abort();
  };
  (void)formats::ParseOctomapBinary(bytes, visit);
}

}  // namespace
}  // namespace isthmus

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isthmus;
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0]) {
    case 't':
      TryTokens(text);
      break;
    case 'c':
      (void)tls::ParseCertificate(text);
      break;
    case 'g':
      TryPoseGraph(text);
      break;
    case 'm':
      TryTrajectory(text);
      break;
    default:
      TryOctomap(text);
      break;
  }
  return 0;
}
