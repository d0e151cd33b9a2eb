// A cloud as it travels: named fields in fixed-size records, like sensor_msgs/PointCloud2 and
// foxglove.PointCloud, onto which it maps without loss.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace isthmus {

enum class ScalarType : uint8_t {  // Values of sensor_msgs/PointField.datatype.
  kInt8 = 1,
  kUint8 = 2,
  kInt16 = 3,
  kUint16 = 4,
  kInt32 = 5,
  kUint32 = 6,
  kFloat32 = 7,
  kFloat64 = 8,
};

// Bytes of one value.
constexpr uint32_t SizeOf(ScalarType type) {
  switch (type) {
    case ScalarType::kInt8:
    case ScalarType::kUint8:
      return 1;
    case ScalarType::kInt16:
    case ScalarType::kUint16:
      return 2;
    case ScalarType::kInt32:
    case ScalarType::kUint32:
    case ScalarType::kFloat32:
      return 4;
    case ScalarType::kFloat64:
      return 8;
  }
  return 0;
}

struct PointField {
  std::string name;
  uint32_t offset = 0;  // Bytes from the start of a record.
  ScalarType type = ScalarType::kFloat32;
  uint32_t count = 1;  // Values of that type, one after the other.
};

enum class PayloadEncoding : uint8_t {
  kRaw,        // `data` is width * height records of `stride` bytes, little endian.
  kQuantized,  // `data` is compressed; see core/codec/quantized.h.
  // Only for points that the server sends: `data` is a Draco cloud; see core/codec/draco_cloud.h.
  kDraco,
};

// Layouts of kQuantized: 1, and 2 for scans of spinning LiDARs. A reader of a version reads all
// before it.
inline constexpr int kQuantizedVersion = 2;

struct PointPayload {
  PayloadEncoding encoding = PayloadEncoding::kRaw;
  uint32_t width = 0;   // Points per row.
  uint32_t height = 1;  // Rows; more than 1 for organised clouds, whose rows or columns are rings.
  uint32_t stride = 0;  // Bytes per record once decoded.
  std::vector<PointField> fields;
  double resolution_m = 0;  // Quantisation step of x, y, z; 0 when raw.
  std::string data;
};

}  // namespace isthmus
