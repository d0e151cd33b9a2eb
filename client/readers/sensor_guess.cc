#include "client/readers/sensor_guess.h"

#include <algorithm>

#include "core/codec/payload_layout.h"

namespace isthmus::readers {

std::string GuessSensor(const PointPayload& raw) {
  const PointField* ring = codec::FindField(raw, {"ring", "channel", "line", "row", "laser_id"});
  double highest = raw.height > 1 ? raw.height - 1.0 : -1;
  if (ring != nullptr) {
    for (const double value : codec::ReadColumn(raw, *ring)) highest = std::max(highest, value);
  }
  if (highest < 0 || highest >= 128) return "";
  return highest < 16 ? "vlp16" : highest < 32 ? "hdl32" : highest < 64 ? "hdl64" : "os1-128";
}

}  // namespace isthmus::readers
