// A match for a person, as `graph` and `match` print it.
#pragma once

#include <absl/strings/str_format.h>

#include <string>

#include "client/cli/pose_text.h"
#include "client/library/records.h"

namespace isthmus::cli {

// Two lines, each with its end.
inline std::string MatchText(const client::MatchEdge& edge) {
  const Match& match = edge.match;
  std::string text = absl::StrFormat(
      "%s ~ %s: %s%s, %s: %s\n", match.a.value(), match.b.value(), ToString(match.state),
      edge.in_tree ? " (carries the map)" : "", match.reason, match.detail);
  return text + absl::StrFormat(
                    "  confidence %.2f, overlap %.2f, inliers %d, free space %.3f, by %s: %s\n",
                    match.confidence, match.overlap, match.inliers, match.free_space,
                    match.matcher.empty() ? "-" : match.matcher, PoseText(match.T_a_b));
}

}  // namespace isthmus::cli
