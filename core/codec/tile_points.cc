#include "core/codec/tile_points.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace isthmus::codec {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr char kTileMagic[] = {'P', 'T', 'S', '2'};
constexpr double kPositionSteps = 65535;  // Layout.

// Precedes the columns.
struct TileHeader {
  char magic[4];
  uint32_t count;
  double origin[3], scale[3];
};
static_assert(sizeof(TileHeader) == 56);
// 3 * u16 position, intensity, robot, last seen, label. The columns before last seen take a
// multiple of 8.
constexpr size_t kBytesPerTilePoint = 13;

uint16_t StepOf(double value, double origin, double scale) {
  if (!(scale > 0)) return 0;
  return static_cast<uint16_t>(
      std::clamp(std::round((value - origin) / scale), 0.0, kPositionSteps));
}

uint8_t ByteOf(float intensity) {
  // Written so that NaN becomes 0.
  return intensity > 0 ? static_cast<uint8_t>(std::lround(std::min(intensity, 255.F))) : 0;
}

}  // namespace

std::string WriteTilePoints(const std::vector<MapPoint>& points) {
  Box bounds;
  for (const MapPoint& p : points) bounds.Extend(Eigen::Vector3d(p.x, p.y, p.z));
  TileHeader header{{kTileMagic[0], kTileMagic[1], kTileMagic[2], kTileMagic[3]},
                    static_cast<uint32_t>(points.size()),
                    {},
                    {}};
  for (int axis = 0; axis < 3 && !points.empty(); ++axis) {
    header.origin[axis] = bounds.min[axis];
    header.scale[axis] = (bounds.max[axis] - bounds.min[axis]) / kPositionSteps;
  }
  std::string bytes(sizeof(header) + kBytesPerTilePoint * points.size(), '\0');
  std::memcpy(bytes.data(), &header, sizeof(header));
  char* position = bytes.data() + sizeof(header);
  char* intensity = position + 6 * points.size();
  char* robot = intensity + points.size();
  char* stamp = robot + points.size();
  char* label = stamp + sizeof(uint32_t) * points.size();
  for (const MapPoint& p : points) {
    const double at[] = {p.x, p.y, p.z};
    for (int axis = 0; axis < 3; ++axis, position += sizeof(uint16_t)) {
      const uint16_t step = StepOf(at[axis], header.origin[axis], header.scale[axis]);
      std::memcpy(position, &step, sizeof(step));
    }
    *intensity++ = static_cast<char>(ByteOf(p.intensity));
    *robot++ = static_cast<char>(std::min<uint32_t>(p.robot, 255));
    std::memcpy(stamp, &p.stamp, sizeof(p.stamp));
    stamp += sizeof(p.stamp);
    *label++ = static_cast<char>(p.label);
  }
  return bytes;
}

absl::StatusOr<std::vector<MapPoint>> ReadTilePoints(absl::string_view bytes) {
  const auto damaged = [] { return absl::DataLossError("these bytes are no points of a tile"); };
  TileHeader header;
  if (bytes.size() < sizeof(header)) return damaged();
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (!std::equal(std::begin(kTileMagic), std::end(kTileMagic), header.magic)) return damaged();
  const size_t count = header.count;
  if (bytes.size() != sizeof(header) + kBytesPerTilePoint * count) return damaged();
  const char* const position = bytes.data() + sizeof(header);
  const char* const intensity = position + 6 * count;
  std::vector<MapPoint> points(count);
  for (size_t i = 0; i < count; ++i) {
    uint16_t steps[3];
    std::memcpy(steps, position + 6 * i, sizeof(steps));
    float* const at[] = {&points[i].x, &points[i].y, &points[i].z};
    for (int axis = 0; axis < 3; ++axis) {
      *at[axis] = static_cast<float>(header.origin[axis] + header.scale[axis] * steps[axis]);
    }
    points[i].intensity = static_cast<uint8_t>(intensity[i]);
    points[i].robot = static_cast<uint8_t>(intensity[count + i]);
    std::memcpy(&points[i].stamp, intensity + 2 * count + 4 * i, sizeof(uint32_t));
    points[i].label = static_cast<PointClass>(static_cast<uint8_t>(intensity[6 * count + i]));
  }
  return points;
}

}  // namespace isthmus::codec
