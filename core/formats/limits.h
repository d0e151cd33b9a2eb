// Limits of the files that are written.
#pragma once

#include <cstddef>

namespace isthmus::formats {

// Bytes of messages after which a chunk of an MCAP file is closed; a larger message has one of its
// own. A megabyte, as MCAP's own programs have it: smaller ones make the index long, larger ones
// make readers that look for one message read more.
inline constexpr size_t kMcapChunkBytes = size_t{1} << 20;

}  // namespace isthmus::formats
