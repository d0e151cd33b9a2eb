#include "core/codec/draco_cloud.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>
#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/point_cloud/point_cloud.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/byte_stream.h"
#include "core/codec/column.h"
#include "core/codec/payload_layout.h"
#include "core/codec/quantized_columns.h"

namespace isthmus::codec {
namespace {

// Offsets in a record of the values that Draco's attributes hold.
struct Offsets {
  uint32_t axes[3] = {};
  std::vector<uint32_t> others;
};

absl::StatusOr<Offsets> FindOffsets(const PointPayload& payload) {
  const PointField* axes[] = {FindField(payload, {"x"}), FindField(payload, {"y"}),
                              FindField(payload, {"z"})};
  Offsets offsets;
  for (const PointField& field : payload.fields) {
    const auto* axis = std::find(std::begin(axes), std::end(axes), &field);
    const bool is_axis = axis != std::end(axes);
    if (field.count != 1 || SizeOf(field.type) != 4 ||
        (is_axis && field.type != ScalarType::kFloat32)) {
      return absl::InvalidArgumentError(
          absl::StrCat("Draco takes x y z as float32 and single values of four bytes; field '",
                       field.name, "' is ", field.count, " of ", ToString(field.type)));
    }
    if (is_axis) {
      offsets.axes[axis - axes] = field.offset;
    } else {
      offsets.others.push_back(field.offset);
    }
  }
  if (offsets.others.size() <= kMaxDracoFields) return offsets;
  return absl::InvalidArgumentError(absl::StrCat("Draco takes at most ", kMaxDracoFields,
                                                 " fields beside x y z; there are ",
                                                 offsets.others.size()));
}

// Settings of the tree, Draco's way for points without an order. Its other one, differences from
// point to point, takes more, and far longer if a field has many values.
constexpr uint8_t kTreeLevel = 6;  // The best, which speed 0 chooses.
constexpr int kSlowest = 0;

void AppendAttribute(draco::GeometryAttribute::Type type, draco::DataType data_type, uint8_t count,
                     uint8_t id, std::string& out) {
  for (const int byte : {int{type}, int{data_type}, int{count}, 0 /* not normalised */, int{id}}) {
    out.push_back(static_cast<char>(byte));
  }
}

// The beginning of a cloud of so many points, up to the width of the numbers, in Draco's bit stream
// 2.3.
std::string Beginning(uint32_t points, size_t others) {
  std::string out("DRACO\x02\x03\x00\x01\x00\x00", 11);  // A point cloud, a tree, no metadata.
  AppendBytes(points, out);
  out.push_back(1);  // All attributes are in one tree.
  out.push_back(static_cast<char>(1 + others));
  AppendAttribute(draco::GeometryAttribute::POSITION, draco::DT_INT32, 3, 0, out);
  for (size_t i = 0; i < others; ++i) {
    AppendAttribute(draco::GeometryAttribute::GENERIC, draco::DT_UINT32, 1,
                    static_cast<uint8_t>(1 + i), out);
  }
  out.push_back(kTreeLevel);
  return out;
}

// Values point by point, `count` of each.
template <typename T>
void AddAttribute(draco::GeometryAttribute::Type type, draco::DataType data_type, int8_t count,
                  const std::vector<T>& values, draco::PointCloud& cloud) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, count, data_type, false, count * int64_t{sizeof(T)}, 0);
  const int id = cloud.AddAttribute(attribute, true, cloud.num_points());
  cloud.attribute(id)->buffer()->Write(0, values.data(), values.size() * sizeof(T));
}

absl::Status AddPositions(const PointPayload& raw, const Offsets& offsets, double resolution_m,
                          draco::PointCloud& cloud) {
  const double scale = 1.0 / resolution_m;
  std::vector<int32_t> steps(3 * PointCount(raw));
  int32_t* to = steps.data();
  for (size_t i = 0; i < PointCount(raw); ++i) {
    for (const uint32_t offset : offsets.axes) {
      const Rounded rounded =
          RoundToSteps(LoadAs<float>(raw.data.data() + i * raw.stride + offset), scale, to++);
      if (rounded == Rounded::kNoValue) {
        return absl::InvalidArgumentError("a coordinate is not finite, which Draco cannot keep");
      }
      if (rounded == Rounded::kTooFar) return CoordinateTooFar(resolution_m);
    }
  }
  AddAttribute(draco::GeometryAttribute::POSITION, draco::DT_INT32, 3, steps, cloud);
  return absl::OkStatus();
}

void AddOther(const PointPayload& raw, uint32_t offset, draco::PointCloud& cloud) {
  std::vector<uint32_t> values(PointCount(raw));
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = LoadAs<uint32_t>(raw.data.data() + i * raw.stride + offset);
  }
  AddAttribute(draco::GeometryAttribute::GENERIC, draco::DT_UINT32, 1, values, cloud);
}

absl::Status Encode(const draco::PointCloud& cloud, std::string& out) {
  draco::ExpertEncoder encoder(cloud);
  encoder.SetSpeedOptions(kSlowest, kSlowest);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_KD_TREE_ENCODING);
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok()) return absl::InternalError(absl::StrCat("Draco: ", status.error_msg()));
  out.assign(buffer.data(), buffer.size());
  return absl::OkStatus();
}

// Draco trusts counts: of attributes, and of points in the tree. The counts that it will find are
// compared with the right ones.
absl::Status CheckBeginning(const PointPayload& packed, const Offsets& offsets) {
  const auto points = static_cast<uint32_t>(PointCount(packed));
  const std::string beginning = Beginning(points, offsets.others.size());
  const size_t count_at = beginning.size() + sizeof(uint32_t);  // Behind the width of numbers.
  const bool has_all = packed.data.size() >= count_at + sizeof(uint32_t);
  if (has_all && packed.data.compare(0, beginning.size(), beginning) == 0 &&
      LoadAs<uint32_t>(&packed.data[count_at]) == points) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("the data are not a Draco cloud of ", points, " points of these fields"));
}

absl::StatusOr<std::unique_ptr<draco::PointCloud>> Decode(const PointPayload& packed,
                                                          const Offsets& offsets) {
  draco::DecoderBuffer buffer;
  buffer.Init(packed.data.data(), packed.data.size());
  draco::Decoder decoder;
  auto cloud = decoder.DecodePointCloudFromBuffer(&buffer);
  const auto damaged = [](absl::string_view why) {
    return absl::InvalidArgumentError(absl::StrCat("the Draco cloud is damaged: ", why));
  };
  if (!cloud.ok()) return damaged(cloud.status().error_msg());
  if (buffer.remaining_size() != 0) return damaged("something follows it");
  if (cloud.value()->num_attributes() != static_cast<int>(1 + offsets.others.size())) {
    return damaged("attributes are missing");
  }
  for (int i = 0; i < cloud.value()->num_attributes(); ++i) {
    if (cloud.value()->attribute(i)->size() != PointCount(packed)) return damaged("it has gaps");
  }
  return std::move(cloud).value();
}

}  // namespace

absl::StatusOr<PointPayload> PackDraco(const PointPayload& raw, double resolution_m) {
  if (raw.encoding != PayloadEncoding::kRaw) {
    return absl::InvalidArgumentError("the payload is compressed already");
  }
  if (auto status = CheckRounded(raw, resolution_m); !status.ok()) return status;
  const absl::StatusOr<Offsets> offsets = FindOffsets(raw);
  if (!offsets.ok()) return offsets.status();
  draco::PointCloud cloud;
  cloud.set_num_points(static_cast<uint32_t>(PointCount(raw)));
  if (auto status = AddPositions(raw, *offsets, resolution_m, cloud); !status.ok()) return status;
  for (const uint32_t offset : offsets->others) AddOther(raw, offset, cloud);
  PointPayload packed;
  packed.encoding = PayloadEncoding::kDraco;
  packed.width = raw.width;
  packed.height = raw.height;
  packed.stride = raw.stride;
  packed.fields = raw.fields;
  packed.resolution_m = resolution_m;
  if (auto status = Encode(cloud, packed.data); !status.ok()) return status;
  return packed;
}

absl::StatusOr<PointPayload> UnpackDraco(const PointPayload& packed) {
  if (packed.encoding != PayloadEncoding::kDraco) {
    return absl::InvalidArgumentError("the payload is no Draco cloud");
  }
  if (auto status = CheckRounded(packed, packed.resolution_m); !status.ok()) return status;
  const absl::StatusOr<Offsets> offsets = FindOffsets(packed);
  if (!offsets.ok()) return offsets.status();
  if (auto status = CheckBeginning(packed, *offsets); !status.ok()) return status;
  const auto cloud = Decode(packed, *offsets);
  if (!cloud.ok()) return cloud.status();

  PointPayload raw;
  raw.width = packed.width;
  raw.height = packed.height;
  raw.stride = packed.stride;
  raw.fields = packed.fields;
  raw.data.resize(PointCount(raw) * raw.stride);
  for (uint32_t i = 0; i < PointCount(raw); ++i) {
    char* record = raw.data.data() + size_t{i} * raw.stride;
    const draco::AttributeValueIndex at(i);
    int32_t steps[3];
    (*cloud)->attribute(0)->GetValue(at, steps);
    for (int axis = 0; axis < 3; ++axis) {
      StoreAs(static_cast<float>(steps[axis] * packed.resolution_m), record + offsets->axes[axis]);
    }
    for (size_t k = 0; k < offsets->others.size(); ++k) {
      (*cloud)->attribute(static_cast<int>(1 + k))->GetValue(at, record + offsets->others[k]);
    }
  }
  return raw;
}

}  // namespace isthmus::codec
