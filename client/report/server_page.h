// The page of a server: what merged, why, how well and how fast, and what waits.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "client/report/figures.h"
#include "client/report/server_state.h"

namespace isthmus::report {

// "match_graph", unless there are fewer than two sessions or more than kGraphSessions, and "map_N"
// for the components whose points were read, whose pixels are written to `folder`. Errors as those
// of TopDownPicture.
absl::StatusOr<std::vector<Figure>> FiguresOf(const ServerState& state, const std::string& folder);

// `figures` were drawn in `folder`. Internal where one cannot be read.
absl::StatusOr<std::string> ServerPage(const ServerState& state, const std::vector<Figure>& figures,
                                       const std::string& folder);

}  // namespace isthmus::report
