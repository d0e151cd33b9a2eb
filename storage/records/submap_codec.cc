#include "storage/records/submap_codec.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "core/byte_stream.h"
#include "core/codec/payload_layout.h"
#include "core/codec/quantized.h"
#include "core/io/crc32c.h"
#include "storage/records/pose_codec.h"

namespace isthmus::storage {
namespace {

constexpr char kSubmapMagic[] = "ISM1";
constexpr size_t kSubmapMagicSize = 4;
constexpr size_t kKeyframeSize = 2 * 8 + 7 * 8;

// A point's record: x y z intensity as float32, keyframe as uint16.
PointPayload PointLayout(size_t points) {
  PointPayload payload;
  payload.width = static_cast<uint32_t>(points);
  payload.stride = 18;
  payload.fields = {
      {"x", 0}, {"y", 4}, {"z", 8}, {"intensity", 12}, {"keyframe", 16, ScalarType::kUint16}};
  return payload;
}

absl::Status AppendPoints(const Submap& submap, double resolution_m, std::string& body) {
  if (submap.points.empty()) return absl::OkStatus();
  PointPayload raw = PointLayout(submap.points.size());
  raw.data.reserve(submap.points.size() * raw.stride);
  for (const SubmapPoint& point : submap.points) {
    for (const float value : {point.x, point.y, point.z, point.intensity}) {
      AppendBytes(value, raw.data);
    }
    AppendBytes(point.keyframe, raw.data);
  }
  absl::StatusOr<PointPayload> quantized = codec::Quantize(raw, resolution_m);
  if (!quantized.ok()) return quantized.status();
  body += quantized->data;
  return absl::OkStatus();
}

absl::Status ReadPoints(ByteReader& reader, uint32_t count, double resolution_m, Submap& submap) {
  submap.points.clear();
  if (count == 0) {
    return reader.remaining() == 0 ? absl::OkStatus() : absl::DataLossError("it is too long");
  }
  PointPayload quantized = PointLayout(count);
  quantized.encoding = PayloadEncoding::kQuantized;
  quantized.resolution_m = resolution_m;
  quantized.data = reader.Rest();
  absl::StatusOr<PointPayload> raw = codec::Dequantize(quantized);
  if (!raw.ok()) return absl::DataLossError(raw.status().message());
  ByteReader records(raw->data);
  submap.points.resize(count);
  for (SubmapPoint& point : submap.points) {
    point.x = records.Read<float>();
    point.y = records.Read<float>();
    point.z = records.Read<float>();
    point.intensity = records.Read<float>();
    point.keyframe = records.Read<uint16_t>();
    if (point.keyframe >= submap.keyframes.size()) {
      return absl::DataLossError("a point is of a keyframe that is not there");
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::string> EncodeSubmap(const Submap& submap, double resolution_m) {
  std::string body;
  AppendBytes(static_cast<uint32_t>(submap.keyframes.size()), body);
  AppendBytes(static_cast<uint32_t>(submap.points.size()), body);
  AppendBytes(resolution_m, body);
  for (const Keyframe& keyframe : submap.keyframes) {
    AppendBytes(keyframe.sequence, body);
    AppendBytes(keyframe.stamp_ns, body);
    AppendPose(keyframe.T_submap_sensor, body);
  }
  if (auto status = AppendPoints(submap, resolution_m, body); !status.ok()) return status;
  std::string blob(kSubmapMagic, kSubmapMagicSize);
  AppendBytes(io::Crc32c(body.data(), body.size()), blob);
  return blob + body;
}

absl::Status DecodeSubmap(const std::string& blob, Submap& submap) {
  constexpr size_t kBody = kSubmapMagicSize + sizeof(uint32_t);
  if (blob.size() < kBody || blob.compare(0, kSubmapMagicSize, kSubmapMagic) != 0) {
    return absl::DataLossError("it does not begin like a submap");
  }
  const std::string body = blob.substr(kBody);
  const std::string checksum = blob.substr(kSubmapMagicSize, sizeof(uint32_t));
  ByteReader checksum_reader(checksum);
  if (checksum_reader.Read<uint32_t>() != io::Crc32c(body.data(), body.size())) {
    return absl::DataLossError("its checksum is wrong");
  }
  ByteReader reader(body);
  const auto keyframes = reader.Read<uint32_t>();
  const auto points = reader.Read<uint32_t>();
  const auto resolution_m = reader.Read<double>();
  if (!reader.ok() || reader.remaining() / kKeyframeSize < keyframes) {
    return absl::DataLossError("it is too short for its keyframes");
  }
  submap.keyframes.resize(keyframes);
  for (Keyframe& keyframe : submap.keyframes) {
    keyframe.sequence = reader.Read<uint64_t>();
    keyframe.stamp_ns = reader.Read<int64_t>();
    keyframe.T_submap_sensor = ReadPose(reader);
  }
  return ReadPoints(reader, points, resolution_m, submap);
}

}  // namespace isthmus::storage
