// Scans as they travel, from any bytes: nothing may crash, hang or take all memory.
//
// The first byte chooses the layout and how much of a payload is put together here, so that the
// code behind checksums and compression is reached; the rest is the bytes of that. A payload that
// is read is packed again and must come back as it was.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "core/byte_stream.h"
#include "core/codec/payload_layout.h"
#include "core/codec/quantized.h"
#include "core/codec/scan_decoder.h"
#include "core/codec/zstd_frame.h"
#include "core/io/crc32c.h"

namespace isthmus::codec {
namespace {

constexpr size_t kPoints = 48;
constexpr size_t kOtherBytes = 4 + 2 + 4;  // Intensity, ring and time of a point.

PointPayload Layout(uint8_t choice) {
  PointPayload payload;
  payload.encoding = PayloadEncoding::kQuantized;
  payload.width = kPoints;
  payload.stride = 22;
  payload.resolution_m = 0.002;
  payload.fields = {{"x", 0, ScalarType::kFloat32},    {"y", 4, ScalarType::kFloat32},
                    {"z", 8, ScalarType::kFloat32},    {"intensity", 12, ScalarType::kFloat32},
                    {"ring", 16, ScalarType::kUint16}, {"time", 18, ScalarType::kFloat32}};
  if ((choice & 1) != 0) payload.fields[5].type = ScalarType::kUint32;
  if ((choice & 2) != 0) payload.fields[4].type = ScalarType::kInt16;
  return payload;
}

// Up to `size` bytes of `bytes` from `at` on, filled up with zeros.
std::string Take(const std::string& bytes, size_t& at, size_t size) {
  std::string taken = at < bytes.size() ? bytes.substr(at, size) : std::string();
  at += taken.size();
  taken.resize(size);
  return taken;
}

// Version 2: columns, model and symbols are the bytes.
std::string Rays(const std::string& bytes) {
  size_t at = 0;
  std::string body("\4\4\4\0\0\0", 6);
  std::string frame;
  if (!AppendZstdFrame(Take(bytes, at, kPoints * kOtherBytes), frame).ok()) abort();
  AppendBytes(static_cast<uint32_t>(frame.size()), body);
  body += frame;
  const size_t rings = at < bytes.size() ? static_cast<uint8_t>(bytes[at]) % 20 : 0;
  ++at;
  AppendBytes(uint16_t{4}, body);
  AppendBytes(uint16_t{5}, body);
  AppendBytes(static_cast<uint16_t>(rings), body);
  body += Take(bytes, at, 12 + 16 * rings);
  std::string symbols = Take(bytes, at, 2 * kPoints);
  const std::string escapes = at < bytes.size() ? bytes.substr(at) : std::string();
  AppendBytes(static_cast<uint32_t>(escapes.size()), body);
  if (!AppendZstdFrame(symbols + escapes, body).ok()) abort();
  return body;
}

// A payload that can be read can be packed, and is read as it was.
void PackAgain(const PointPayload& raw, double step) {
  const auto packed = Quantize(raw, step);
  if (!packed.ok()) return;  // Too far.
  const auto once = Dequantize(*packed);
  if (!once.ok()) abort();
  const auto old = Quantize(raw, step, 1);
  if (!old.ok()) abort();
  const auto by_old = Dequantize(*old);
  if (!by_old.ok() || by_old->data != once->data) abort();
}

void Read(uint8_t choice, const std::string& bytes) {
  PointPayload payload = Layout(choice);
  const std::string body = (choice & 4) != 0 ? Rays(bytes) : bytes;
  payload.data = {'I', 'Q', (choice & 8) != 0 ? '\1' : '\2', '\0'};
  AppendBytes(io::Crc32c(body.data(), body.size()), payload.data);
  payload.data += body;
  if (const auto raw = Dequantize(payload); raw.ok()) PackAgain(*raw, payload.resolution_m);
  (void)DecodeScan(payload, 1, 2);
}

// The bytes are points.
void Pack(uint8_t choice, const std::string& bytes) {
  PointPayload payload = Layout(choice);
  payload.encoding = PayloadEncoding::kRaw;
  payload.width = static_cast<uint32_t>(bytes.size() / payload.stride);
  payload.resolution_m = 0;
  payload.data = bytes.substr(0, size_t{payload.width} * payload.stride);
  PackAgain(payload, 0.002);
}

}  // namespace
}  // namespace isthmus::codec

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if ((data[0] & 16) != 0) {
    isthmus::codec::Pack(data[0], bytes);
  } else {
    isthmus::codec::Read(data[0], bytes);
  }
  return 0;
}
