#include "client/readers/ring_sensor.h"

#include <algorithm>

#include "client/readers/limits.h"
#include "core/codec/column.h"
#include "core/codec/payload_layout.h"
#include "core/codec/scan_decoder.h"

namespace isthmus::readers {

void RingSensor::Look(const PointPayload& payload) {
  if (scans_ == kRingScans) return;
  ++scans_;
  // As Livox' own drivers write clouds.
  livox_ = livox_ || (codec::FindField(payload, {"tag"}) != nullptr &&
                      codec::FindField(payload, {"line"}) != nullptr);
  const PointField* ring = codec::FindRingField(payload);
  if (ring == nullptr) {
    if (payload.height < 2) return;
    const absl::StatusOr<Scan> scan = codec::DecodeScan(payload, 0, 0);
    if (!scan.ok() || !scan->has_ring) return;
    for (const ScanPoint& p : scan->points) highest_ = std::max<double>(highest_, p.ring);
    return;
  }
  codec::ForEachValue(payload, *ring, [&](uint64_t, auto value) {
    const auto number = static_cast<double>(value);
    if (number < kMaxKnownRings) highest_ = std::max(highest_, number);
  });
}

std::string RingSensor::sensor() const {
  if (livox_) return "livox";
  if (highest_ < 0 || highest_ >= kMaxKnownRings) return {};
  return highest_ < 16 ? "vlp16" : highest_ < 32 ? "hdl32" : highest_ < 64 ? "hdl64" : "os1-128";
}

}  // namespace isthmus::readers
