// Points of the map as a Draco cloud, from any bytes: nothing may crash, hang or take all memory.
//
// The first byte chooses how many fields there are. The rest is put behind the beginning that such
// a cloud of so many points must have, so that what Draco itself reads is reached.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "core/codec/draco_cloud.h"
#include "core/codec/payload_layout.h"

namespace isthmus::codec {
namespace {

constexpr uint32_t kPoints = 200;

// Raw, all at the origin.
PointPayload Points(uint32_t others) {
  PointPayload payload;
  payload.width = kPoints;
  for (const char* name : {"x", "y", "z"}) {
    payload.fields.push_back({name, payload.stride});
    payload.stride += 4;
  }
  for (uint32_t i = 0; i < others; ++i) {
    payload.fields.push_back({"intensity", payload.stride, ScalarType::kUint32});
    payload.stride += 4;
  }
  payload.data.resize(size_t{kPoints} * payload.stride);
  return payload;
}

void Read(uint8_t choice, const std::string& bytes) {
  const uint32_t others = choice % 4;
  PointPayload packed = *PackDraco(Points(others), 0.001);
  // Behind the two counts of points and between them the width of numbers, which is any.
  const size_t begins = 11 + 4 + 1 + 1 + 5 * (1 + others) + 1;
  if (bytes.empty()) return;
  packed.data[begins] = bytes[0];
  packed.data.replace(begins + 8, std::string::npos, bytes, 1);
  const auto raw = UnpackDraco(packed);
  if (raw.ok() && raw->data.size() != size_t{kPoints} * raw->stride) std::abort();
}

}  // namespace
}  // namespace isthmus::codec

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  isthmus::codec::Read(data[0], bytes);
  return 0;
}
