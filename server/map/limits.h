// Limits of what a revision says.
#pragma once

#include <cstddef>

namespace isthmus::server {

// Causes of a revision that are named, so that one of a start stays a line or two; the rest is
// counted by its moves.
inline constexpr size_t kMaxCauses = 4;

}  // namespace isthmus::server
