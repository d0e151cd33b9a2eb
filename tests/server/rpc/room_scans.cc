#include "tests/server/rpc/room_scans.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace isthmus::rpc {
namespace {

constexpr int kRings = 16;
constexpr int kAzimuths = 900;
constexpr double kTurnS = 0.1;

struct Block {
  Eigen::Vector3d min, max;
};

const Block kRoom = {{-3, -6, -1.2}, {22, 7, 3}};
const std::array<Block, 4> kPillars = {{{{3, 2, -1.2}, {3.7, 2.9, 3}},
                                        {{8, -4, -1.2}, {9, -3.2, 3}},
                                        {{13, 3, -1.2}, {14.5, 3.6, 3}},
                                        {{17, -2.6, -1.2}, {17.4, -1.4, 3}}}};

// The distances at which the ray enters and leaves the block; enter > leave when it misses.
void Clip(const Block& block, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
          double* enter, double* leave) {
  *enter = -std::numeric_limits<double>::infinity();
  *leave = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (block.min[axis] - origin[axis]) / direction[axis];
    const double b = (block.max[axis] - origin[axis]) / direction[axis];
    *enter = std::max(*enter, std::min(a, b));
    *leave = std::min(*leave, std::max(a, b));
  }
}

double Range(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  double enter = 0;
  double range = 0;
  Clip(kRoom, origin, direction, &enter, &range);  // From inside: the far side is hit.
  for (const Block& pillar : kPillars) {
    double leave = 0;
    Clip(pillar, origin, direction, &enter, &leave);
    if (enter > 0 && enter <= leave) range = std::min(range, enter);
  }
  return range;
}

}  // namespace

v1::PointCloud RoomCloud(const Pose& T_room_begin, const Pose& T_room_end) {
  std::vector<float> values;
  for (int i = 0; i < kAzimuths; ++i) {
    // A hair off the axes, so that no component of a direction is zero. Clockwise from behind.
    const double fraction = (i + 0.37) / kAzimuths;
    const double azimuth = M_PI - 2 * M_PI * fraction;
    const Pose T_room_sensor = Interpolate(T_room_begin, T_room_end, fraction);
    for (int ring = 0; ring < kRings; ++ring) {
      const double elevation = (-15 + 2 * ring) * M_PI / 180;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      const double range = Range(T_room_sensor.translation(), T_room_sensor.rotation() * ray);
      const Eigen::Vector3f p = (range * ray).cast<float>();
      const auto time = static_cast<float>((fraction - 1) * kTurnS);
      values.insert(values.end(), {p.x(), p.y(), p.z(), 1.0F, time, static_cast<float>(ring)});
    }
  }
  v1::PointCloud cloud;
  cloud.set_encoding(v1::PointCloud::RAW);
  cloud.set_width(kRings * kAzimuths);
  cloud.set_stride(24);
  const char* const names[] = {"x", "y", "z", "intensity", "time", "ring"};
  for (uint32_t i = 0; i < 6; ++i) {
    v1::PointField& field = *cloud.add_fields();
    field.set_name(names[i]);
    field.set_offset(4 * i);
    field.set_type(v1::PointField::FLOAT32);
  }
  cloud.set_data(values.data(), values.size() * sizeof(float));
  return cloud;
}

Pose RoomPose(uint64_t sequence) {
  return Pose(Eigen::Vector3d(0.2 * (static_cast<double>(sequence) - 1), 0, 0));
}

v1::StreamScansRequest RoomScan(const std::string& session, uint64_t sequence) {
  v1::StreamScansRequest request;
  request.set_session(session);
  request.mutable_scan()->set_sequence(sequence);
  request.mutable_scan()->set_end_stamp_ns(static_cast<int64_t>(sequence) * 100'000'000);
  *request.mutable_scan()->mutable_cloud() = RoomCloud(RoomPose(sequence - 1), RoomPose(sequence));
  return request;
}

}  // namespace isthmus::rpc
