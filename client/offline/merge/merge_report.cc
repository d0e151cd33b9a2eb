#include "client/offline/merge/merge_report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>

#include "client/console/match_text.h"
#include "client/offline/merge/bare_maps.h"

namespace isthmus::cli {
namespace {

// Something was merged, and by verified matches only.
bool IsVerified(const MergeResult& result) {
  return !result.output.empty() &&
         std::none_of(
             result.graph.matches.begin(), result.graph.matches.end(),
             [](const MatchEdge& edge) { return edge.match.reason == MatchReason::kUnverified; });
}

}  // namespace

Json ToJson(const MergeResult& result) {
  Json out = {{"merged", result.merged},
              {"verified", IsVerified(result)},
              {"lacking", WhatIsLacking(result.inputs)},
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
  for (const MatchEdge& edge : result.graph.matches) {
    Json pair = ToJson(edge);
    pair["accepted"] = edge.match.state == MatchState::kAccepted;
    out["pairs"].push_back(std::move(pair));
  }
  return out;
}

void PrintText(const MergeResult& result) {
  for (const MergeInput& input : result.inputs) {
    absl::PrintF(
        "%s: %s, %d points seen from %s\n", input.robot, input.file, input.points,
        input.viewpoints > 0 ? absl::StrCat(input.viewpoints, " places") : "nobody knows where");
  }
  for (const MatchEdge& edge : result.graph.matches) {
    absl::PrintF("\n%s", MatchText(edge, edge.robot_a.value() + " ~ " + edge.robot_b.value()));
  }
  absl::PrintF("\n");
  for (const std::string& sentence : WhatIsLacking(result.inputs)) absl::PrintF("%s\n", sentence);
  if (result.output.empty()) {
    absl::PrintF("not merged: nothing written\n");
    return;
  }
  absl::PrintF("%s: %s, composed in %.1f ms%s\n", result.output,
               result.merged ? "all in one map" : "only the largest group of those that merged",
               result.info.composition_ms,
               IsVerified(result) ? "" : "; UNVERIFIED: look at it before you trust it");
}

}  // namespace isthmus::cli
