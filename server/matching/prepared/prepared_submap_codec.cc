#include "server/matching/prepared/prepared_submap_codec.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "core/byte_stream.h"
#include "server/matching/prepared/limits.h"

namespace isthmus::matching {
namespace {

struct Header {
  double voxel_m = 0;
  float step_m = 0;
  uint32_t points = 0;
  uint32_t views = 0;
};

struct PackedPoint {
  int16_t position[3];
  int8_t normal[3];
  uint8_t roughness;
};

struct PackedPose {
  double rotation[4];  // x, y, z, w
  double translation[3];
};

static_assert(sizeof(PackedPoint) == 10 && sizeof(PackedPose) == 56);

void AppendBins(const std::vector<uint16_t>& bins, std::string* out) {
  // An image of nothing has no bins.
  std::vector<uint16_t> all = bins;
  all.resize(RangeImage::kBins, 0);
  out->append(reinterpret_cast<const char*>(all.data()), RangeImage::kBins * sizeof(uint16_t));
}

std::vector<uint16_t> TakeBins(ByteReader& reader) {
  std::vector<uint16_t> bins(RangeImage::kBins);
  const std::string bytes = reader.ReadString(RangeImage::kBins * sizeof(uint16_t));
  std::memcpy(bins.data(), bytes.data(), bytes.size());
  return bins;
}

PackedPoint Pack(const SurfacePoint& point, float step_m) {
  PackedPoint packed;
  for (int k = 0; k < 3; ++k) {
    packed.position[k] = static_cast<int16_t>(std::lround(point.position[k] / step_m));
    packed.normal[k] = static_cast<int8_t>(std::lround(127 * point.normal[k]));
  }
  packed.roughness = static_cast<uint8_t>(std::lround(255 * point.roughness));
  return packed;
}

SurfacePoint Unpack(const PackedPoint& packed, float step_m) {
  SurfacePoint point;
  for (int k = 0; k < 3; ++k) {
    point.position[k] = step_m * packed.position[k];
    point.normal[k] = packed.normal[k];
  }
  point.normal.normalize();
  point.roughness = static_cast<float>(packed.roughness) / 255;
  return point;
}

}  // namespace

std::string EncodePreparedSubmap(const PreparedSubmap& prepared) {
  float reach = 1;
  for (const SurfacePoint& point : prepared.surface()) {
    reach = std::max(reach, point.position.cwiseAbs().maxCoeff());
  }
  const float step_m = reach / std::numeric_limits<int16_t>::max();
  std::string bytes;
  AppendBytes(prepared.voxel_m(), bytes);
  AppendBytes(step_m, bytes);
  AppendBytes(static_cast<uint32_t>(prepared.surface().size()), bytes);
  AppendBytes(static_cast<uint32_t>(prepared.views().size()), bytes);
  for (const SurfacePoint& point : prepared.surface()) AppendBytes(Pack(point, step_m), bytes);
  for (const PreparedSubmap::View& view : prepared.views()) {
    const Eigen::Quaterniond& q = view.T_submap_sensor.rotation();
    const Eigen::Vector3d& t = view.T_submap_sensor.translation();
    AppendBytes(PackedPose{{q.x(), q.y(), q.z(), q.w()}, {t.x(), t.y(), t.z()}}, bytes);
    AppendBins(view.image.shortest_cm(), &bytes);
    AppendBins(view.image.longest_cm(), &bytes);
  }
  return bytes;
}

std::shared_ptr<const PreparedSubmap> DecodePreparedSubmap(std::shared_ptr<const Submap> submap,
                                                           const std::string& bytes) {
  constexpr size_t kHeaderBytes = 20;
  constexpr size_t kViewBytes = sizeof(PackedPose) + 2 * RangeImage::kBins * sizeof(uint16_t);
  if (bytes.size() < kHeaderBytes) return nullptr;
  ByteReader reader(bytes);
  Header header;
  header.voxel_m = reader.Read<double>();
  header.step_m = reader.Read<float>();
  header.points = reader.Read<uint32_t>();
  header.views = reader.Read<uint32_t>();
  if (header.views > kMaxViews) return nullptr;
  const bool plausible =
      header.voxel_m > 0 && header.voxel_m < 100 && header.step_m > 0 && header.step_m < 100;
  if (!plausible || bytes.size() != kHeaderBytes + header.points * sizeof(PackedPoint) +
                                        header.views * kViewBytes) {
    return nullptr;
  }
  std::vector<SurfacePoint> surface;
  surface.reserve(header.points);
  for (uint32_t k = 0; k < header.points; ++k) {
    surface.push_back(Unpack(reader.Read<PackedPoint>(), header.step_m));
    if (!surface.back().normal.allFinite()) return nullptr;
  }
  std::vector<PreparedSubmap::View> views;
  for (uint32_t k = 0; k < header.views; ++k) {
    const auto pose = reader.Read<PackedPose>();
    const double* q = pose.rotation;
    const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
    const Pose T(rotation, Eigen::Map<const Eigen::Vector3d>(pose.translation));
    if (!T.IsFinite() || !(std::abs(rotation.norm() - 1) < 1e-6)) return nullptr;
    std::vector<uint16_t> shortest = TakeBins(reader);
    std::vector<uint16_t> longest = TakeBins(reader);
    views.push_back({T, RangeImage(std::move(shortest), std::move(longest))});
  }
  return std::make_shared<const PreparedSubmap>(std::move(submap), header.voxel_m,
                                                std::move(surface), std::move(views));
}

}  // namespace isthmus::matching
