#include "lab/simulation/worlds/walkers.h"

#include <cmath>

namespace isthmus::simulation {
namespace {

constexpr float kRadius = 0.25f, kHeight = 1.75f;

}  // namespace

Walkers::Walkers(const std::vector<Motion>& walks, double begin_s, double end_s) {
  for (const Motion& walk : walks) {
    legs_.push_back(
        {walk(begin_s).translation().cast<float>(), walk(end_s).translation().cast<float>()});
  }
}

void Walkers::Occlude(const Ray& ray, double fraction, float max_range_m, Hit& hit) const {
  for (const Leg& leg : legs_) {
    const Eigen::Vector3f feet = leg.from + static_cast<float>(fraction) * (leg.to - leg.from);
    const Eigen::Vector3f offset = ray.origin - feet;
    // |offset + t direction|^2 = radius^2 in the plane.
    const float a = ray.direction.head<2>().squaredNorm();
    const float b = offset.head<2>().dot(ray.direction.head<2>());
    const float c = offset.head<2>().squaredNorm() - kRadius * kRadius;
    const float discriminant = b * b - a * c;
    if (c <= 0 || b >= 0 || discriminant <= 0) continue;
    const float range = (-b - std::sqrt(discriminant)) / a;
    const Eigen::Vector3f at = offset + range * ray.direction;
    const float reach = hit.range_m < 0 ? max_range_m : hit.range_m;
    if (range >= reach || at.z() < 0 || at.z() > kHeight) continue;
    hit.range_m = range;
    hit.cosine = std::abs(at.head<2>().dot(ray.direction.head<2>())) / kRadius;
    hit.material = Material::kCloth;
    hit.moves = true;
    hit.surface = PointClass::kMover;
  }
}

}  // namespace isthmus::simulation
