// The coding of coordinates by the directions of a RayModel: of each point the difference to the
// predicted distance, and those of the two other coordinates to where the ray then passes.
//
// Both sides compute the same predictions, bit by bit, from what was coded before: IEEE doubles,
// no fused operations, no functions of a library. docs/storage-format.md, "Rays", has the formulas.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "core/codec/ray_model.h"

namespace isthmus::codec {

// Most bytes of escapes that a point takes: 31 bits, and twice 6 + 31.
inline constexpr size_t kMostEscapeBytes = 14;

// The result of coding: a symbol per point for the distance, one for the two others, and the bits
// of values without a symbol.
struct RaySymbols {
  std::string distance;  // n bytes.
  std::string across;    // n bytes.
  std::string escapes;
};

RaySymbols EncodeRays(const RayModel& model, const RayPoints& points);

// The content of RaySymbols, somewhere in memory.
struct RayStreams {
  const char* distance;
  const char* across;
  const char* escapes;
  size_t escape_bytes;
};

// Points that are decoded at a time.
inline constexpr size_t kRayBlock = 256;

// The inverse of EncodeRays, a block after the other. Not thread safe. The streams must stay.
class RayDecoder {
 public:
  RayDecoder(const RayModel& model, const RayStreams& streams);
  ~RayDecoder();

  // Fills x, y, z and is_return of at most kRayBlock points, whose ring (below the model's) and
  // time are there. The streams have symbols for them. False for what EncodeRays did not make,
  // where that shows.
  bool Next(RayPoints& points);
  // True if all escapes were used.
  bool complete() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isthmus::codec
