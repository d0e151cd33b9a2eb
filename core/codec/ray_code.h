// The coding of coordinates by the directions of a RayModel: of each point the difference to the
// predicted distance, and those of the two other coordinates to where the ray then passes.
//
// Both sides compute the same predictions, bit by bit, from what was coded before: IEEE doubles,
// no fused operations, no functions of a library. docs/storage-format.md, "Rays", has the formulas.
#pragma once

#include <cstdint>
#include <string>

#include "core/codec/ray_model.h"

namespace isthmus::codec {

// Most bytes of escapes that a point takes: 31 bits, and twice 6 + 31.
inline constexpr size_t kMostEscapeBytes = 14;

// What coding gives: a symbol per point for the distance, one for the two others, and the bits of
// what no symbol stands for.
struct RaySymbols {
  std::string distance;  // n bytes.
  std::string across;    // n bytes.
  std::string escapes;
};

RaySymbols EncodeRays(const RayModel& model, const RayPoints& points);

// The inverse: fills x, y, z and is_return of `points`, whose ring (below the model's) and time are
// there. False for what EncodeRays did not make, where that shows.
bool DecodeRays(const RayModel& model, const char* distance, const char* across,
                const char* escapes, size_t escape_bytes, RayPoints& points);

}  // namespace isthmus::codec
