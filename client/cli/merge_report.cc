#include "client/cli/merge_report.h"

#include <absl/strings/str_format.h>

#include "client/cli/pose_text.h"

namespace isthmus::cli {

Json ToJson(const MergeResult& result) {
  Json out = {{"merged", result.merged},
              {"file", result.output.empty() ? Json(nullptr) : Json(result.output)},
              {"inputs", Json::array()},
              {"pairs", Json::array()},
              {"placements", ToJson(result.graph)["placements"]},
              {"estimation_ms", result.info.estimation_ms},
              {"composition_ms", result.info.composition_ms}};
  for (const MergeInput& input : result.inputs) {
    out["inputs"].push_back({{"file", input.file},
                             {"robot", input.robot},
                             {"points", input.points},
                             {"viewpoints", input.viewpoints}});
  }
  for (const client::MatchEdge& edge : result.graph.matches) {
    Json pair = ToJson(edge);
    pair["accepted"] = edge.match.state == MatchState::kAccepted;
    out["pairs"].push_back(std::move(pair));
  }
  return out;
}

void PrintText(const MergeResult& result) {
  for (const MergeInput& input : result.inputs) {
    absl::PrintF("%s: %s, %d points seen from %d places\n", input.robot, input.file, input.points,
                 input.viewpoints);
  }
  for (const client::MatchEdge& edge : result.graph.matches) {
    const Match& match = edge.match;
    absl::PrintF("%s ~ %s: %s, %s: %s\n", edge.robot_a.value(), edge.robot_b.value(),
                 match.state == MatchState::kAccepted ? "accepted" : "not accepted", match.reason,
                 match.detail);
    absl::PrintF("  T %s\n  overlap %.2f, inliers %d, confidence %.2f\n ", PoseText(match.T_a_b),
                 match.overlap, match.inliers, match.confidence);
    for (const StageTime& stage : match.stages) {
      absl::PrintF(" %s %.0f ms", stage.stage, stage.ms);
    }
    absl::PrintF("\n");
  }
  if (result.output.empty()) {
    absl::PrintF("not merged: nothing written\n");
  } else {
    absl::PrintF("%s: %s, composed in %.1f ms\n", result.output,
                 result.merged ? "all in one map" : "only the largest group of those that merged",
                 result.info.composition_ms);
  }
}

}  // namespace isthmus::cli
