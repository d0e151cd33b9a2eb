// The changes of a revision as text for a person.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/map/revision.h"

namespace isthmus::cli {

struct MoveSize {
  double metres = 0, degrees = 0;
};
// The distance that a submap moved within one map frame; none if it came, went or changed its
// frame.
std::optional<MoveSize> SizeOf(const SubmapMove& move);

// "2026-11-21 12:46:51" in UTC.
std::string TimeText(int64_t stamp_ns);

// A line each, with its end.
std::string RevisionHeader();
std::string RevisionLine(const RevisionInfo& revision);
// "alice-1/7: moved by 0.412 m, 1.20 deg".
std::string MoveLine(const SubmapMove& move);

}  // namespace isthmus::cli
