// Prepared submaps as bytes, so that they are made once and not again after every restart.
#pragma once

#include <memory>
#include <string>

#include "core/map/submap.h"
#include "server/matching/prepared/prepared_submap.h"

namespace isthmus::matching {

// Under which the bytes are kept; changes with how they are made or written.
inline constexpr char kPreparedSubmapKind[] = "prepared-v1";

// Surface and views: a little-endian header, then per point 3 x int16 position, 3 x int8 normal and
// uint8 roughness, per view its pose and the range image's bins. Positions are rounded to a 32767th
// of the submap's reach (3 mm for 100 m). Compresses well.
std::string EncodePreparedSubmap(const PreparedSubmap& prepared);

// Null where the bytes are not what EncodePreparedSubmap made of some submap; they may be damaged
// in any way. `submap` must be the one they were made of.
std::shared_ptr<const PreparedSubmap> DecodePreparedSubmap(std::shared_ptr<const Submap> submap,
                                                           const std::string& bytes);

}  // namespace isthmus::matching
