#include "client/offline/merge/merge_report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <string>
#include <utility>

#include "client/console/match_text.h"
#include "client/console/say.h"
#include "client/offline/merge/bare_maps.h"

namespace isthmus::cli {
namespace {

// Something was merged, and by verified matches only.
bool IsVerified(const MergeResult& result) {
  return !result.files.map.empty() &&
         std::none_of(
             result.graph.matches.begin(), result.graph.matches.end(),
             [](const MatchEdge& edge) { return edge.match.reason == MatchReason::kUnverified; });
}

Json RivalsJson(const Match& match) {
  Json rivals = Json::array();
  for (const RivalMatch& rival : match.rivals) {
    rivals.push_back({{"t_a_b", cli::ToJson(rival.T_a_b)}, {"confidence", rival.confidence}});
  }
  return rivals;
}

Json NameOrNull(const std::string& file) { return file.empty() ? Json(nullptr) : Json(file); }

void PrintFiles(const MergeResult& result) {
  Say("%s: %s, composed in %.1f ms%s\n", result.files.map,
      result.merged ? "all in one map" : "only the largest group of those that merged",
      result.info.composition_ms,
      IsVerified(result) ? "" : "; UNVERIFIED: check it before you trust it");
  for (const MergeInput& input : result.inputs) {
    const TrajectoryFile& written = input.trajectory;
    if (written.file.empty()) continue;
    Say("%s: %d poses of %s in the frame of the merged map", written.file, written.poses,
        input.robot);
    if (!written.left_out.empty()) {
      Say("; segments in other maps, not in it: %s", absl::StrJoin(written.left_out, ", "));
    }
    Say("\n");
  }
  if (!result.files.picture.empty()) Say("%s: the map from above\n", result.files.picture);
}

}  // namespace

Json ToJson(const MergeResult& result) {
  Json out = {{"merged", result.merged},
              {"verified", IsVerified(result)},
              {"lacking", WhatIsLacking(result.inputs)},
              {"file", NameOrNull(result.files.map)},
              {"picture", NameOrNull(result.files.picture)},
              {"inputs", Json::array()},
              {"pairs", Json::array()},
              {"placements", cli::ToJson(result.graph)["placements"]},
              {"estimation_ms", result.info.estimation_ms},
              {"composition_ms", result.info.composition_ms}};
  for (const MergeInput& input : result.inputs) {
    out["inputs"].push_back(
        {{"file", input.file},
         {"robot", input.robot},
         {"points", input.points},
         {"viewpoints", input.viewpoints},
         {"moved_by", {input.moved_by.x(), input.moved_by.y(), input.moved_by.z()}},
         {"drive", input.is_drive},
         {"trajectory", NameOrNull(input.trajectory.file)}});
  }
  for (const MatchEdge& edge : result.graph.matches) {
    Json pair = cli::ToJson(edge);
    pair["accepted"] = edge.match.state == MatchState::kAccepted;
    pair["rivals"] = RivalsJson(edge.match);
    out["pairs"].push_back(std::move(pair));
  }
  return out;
}

void PrintText(const MergeResult& result) {
  for (const MergeInput& input : result.inputs) {
    if (input.is_drive) {
      Say("%s: %s, %d scans\n", input.robot, input.file, input.viewpoints);
      continue;
    }
    Say("%s: %s, %d points, %s\n", input.robot, input.file, input.points,
        input.viewpoints > 0 ? absl::StrCat("seen from ", input.viewpoints, " places")
                             : "without sensor poses");
  }
  for (const MatchEdge& edge : result.graph.matches) {
    SayLines("\n" + MatchText(edge, edge.robot_a.value() + " ~ " + edge.robot_b.value()));
  }
  Say("\n");
  for (const std::string& sentence : WhatIsLacking(result.inputs)) Say("%s\n", sentence);
  if (result.files.map.empty()) {
    Say("not merged: no file was written\n");
    return;
  }
  PrintFiles(result);
}

}  // namespace isthmus::cli
