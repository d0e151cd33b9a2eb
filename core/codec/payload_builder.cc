#include "core/codec/payload_builder.h"

#include <array>

#include "core/codec/column.h"

namespace isthmus::codec {
namespace {

// Packed x y z intensity as float32; more fields may follow.
PointPayload StartPayload(size_t points) {
  PointPayload payload;
  payload.width = static_cast<uint32_t>(points);
  payload.stride = 16;
  payload.fields = {{"x", 0}, {"y", 4}, {"z", 8}, {"intensity", 12}};
  return payload;
}

void AddField(PointPayload& payload, const char* name, ScalarType type) {
  payload.fields.push_back({name, payload.stride, type});
  payload.stride += SizeOf(type);
}

template <typename P>
void StoreXyzi(const P& point, char* record) {
  StoreAs(std::array<float, 4>{point.x, point.y, point.z, point.intensity}, record);
}

}  // namespace

PointPayload MakePayload(const std::vector<ScanPoint>& points, bool has_ring, bool has_time) {
  PointPayload payload = StartPayload(points.size());
  const uint32_t ring_offset = payload.stride;
  if (has_ring) AddField(payload, "ring", ScalarType::kUint16);
  const uint32_t time_offset = payload.stride;
  if (has_time) AddField(payload, "time", ScalarType::kFloat32);
  payload.data.resize(points.size() * payload.stride);
  char* record = payload.data.data();
  for (const ScanPoint& point : points) {
    StoreXyzi(point, record);
    if (has_ring) StoreAs(point.ring, record + ring_offset);
    if (has_time) StoreAs(point.time, record + time_offset);
    record += payload.stride;
  }
  return payload;
}

PointPayload MakePayload(const Scan& scan) {
  return MakePayload(scan.points, scan.has_ring, scan.has_time);
}

PointPayload MakePayload(const Cloud& cloud) {
  PointPayload payload = StartPayload(cloud.size());
  payload.data.resize(cloud.size() * payload.stride);
  char* record = payload.data.data();
  for (const Point& point : cloud) {
    StoreXyzi(point, record);
    record += payload.stride;
  }
  return payload;
}

}  // namespace isthmus::codec
