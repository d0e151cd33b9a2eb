#include "lab/simulation/worlds/cars.h"

#include <cmath>
#include <numbers>

namespace isthmus::simulation {
namespace {

struct Block {
  Eigen::Vector3f low, high;  // Corners, in the car's frame.
};

const Block kBodies[] = {{{-2.2f, -0.9f, 0.25f}, {2.2f, 0.9f, 0.85f}},
                         {{-1.4f, -0.78f, 0.85f}, {0.8f, 0.78f, 1.45f}}};
constexpr float kReachM = 2.4f;  // From the point on the road, level, to the farthest corner.

// The point where the ray enters the block (slabs), if it begins outside and before it: range and
// which side.
bool Enter(const Block& block, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
           float* range, int* side) {
  float enter = -1, leave = 1e9f;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) {
      if (origin[axis] < block.low[axis] || origin[axis] > block.high[axis]) return false;
      continue;
    }
    float near = (block.low[axis] - origin[axis]) / direction[axis];
    float far = (block.high[axis] - origin[axis]) / direction[axis];
    if (near > far) std::swap(near, far);
    if (near > enter) {
      enter = near;
      *side = axis;
    }
    leave = std::min(leave, far);
  }
  *range = enter;
  return enter > 0 && enter < leave;
}

}  // namespace

Cars::Cars(const std::vector<Motion>& drives, double begin_s, double end_s) {
  for (const Motion& drive : drives) {
    const Pose from = drive(begin_s), to = drive(end_s);
    const double by = std::remainder(to.Yaw() - from.Yaw(), 2 * std::numbers::pi);
    legs_.push_back({from.translation().cast<float>(), to.translation().cast<float>(),
                     static_cast<float>(from.Yaw()), static_cast<float>(by)});
  }
}

void Cars::Occlude(const Ray& ray, double fraction, float max_range_m, Hit& hit) const {
  const auto f = static_cast<float>(fraction);
  const Eigen::Vector2f heading = ray.direction.head<2>();
  for (const Leg& leg : legs_) {
    const Eigen::Vector3f offset = ray.origin - (leg.from + f * (leg.to - leg.from));
    // Passes it by: closest approach of the ray's line in the plane.
    const float cross = offset.x() * heading.y() - offset.y() * heading.x();
    if (cross * cross > kReachM * kReachM * heading.squaredNorm()) continue;
    const float yaw = leg.yaw_from + f * leg.yaw_by, c = std::cos(yaw), s = std::sin(yaw);
    const auto turned = [c, s](const Eigen::Vector3f& v) {
      return Eigen::Vector3f(c * v.x() + s * v.y(), c * v.y() - s * v.x(), v.z());
    };
    const Eigen::Vector3f origin = turned(offset), direction = turned(ray.direction);
    for (const Block& block : kBodies) {
      float range = 0;
      int side = 0;
      const float reach = hit.range_m < 0 ? max_range_m : hit.range_m;
      if (!Enter(block, origin, direction, &range, &side) || range >= reach) continue;
      hit.range_m = range;
      hit.cosine = std::abs(direction[side]);
      hit.material = Material::kMetal;
      hit.moves = true;
      hit.surface = PointClass::kVehicle;
    }
  }
}

}  // namespace isthmus::simulation
