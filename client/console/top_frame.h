// The frame that `isthmus top` shows: a server's status as lines of text.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/records/server_status.h"

namespace isthmus::cli {

struct TopView {
  std::string address;                 // As the user gave it.
  std::optional<ServerStatus> status;  // The last that came; none so far.
  std::optional<ServerStatus> before;  // The one before, for what is per second.
  std::string problem;                 // Why there is no newer one; empty while all is well.
};

// No line is longer than `columns`: the columns that matter least are left out, then lines are cut.
// Nothing but printable ASCII, whatever the server said.
std::vector<std::string> TopLines(const TopView& view, size_t columns);

}  // namespace isthmus::cli
