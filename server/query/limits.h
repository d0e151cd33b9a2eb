// Limits of the pieces in which a file is written.
#pragma once

#include <cstddef>

namespace isthmus::query {

// Points of a piece, 200 kB of binary records or about 500 kB of text, and bytes of a piece of what
// is compressed as a whole. Memory of an export; below gRPC's 4 MB of a message.
inline constexpr size_t kPointsPerPiece = 10000, kBytesPerPiece = size_t{1} << 19;

}  // namespace isthmus::query
