#include "server/matching/index/plan_image.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "server/matching/index/limits.h"

namespace isthmus::matching {
namespace {

PlanImage MakeEmpty(int size) {
  PlanImage image;
  for (auto& plane : image.planes) plane.assign(static_cast<size_t>(size) * size, 0.0f);
  return image;
}

// The cell of a place relative to the plan's centre.
size_t IndexOf(const Eigen::Vector2f& at, float cell_m, int size) {
  const auto wrapped = [&](float m) {
    const int cell = static_cast<int>(std::floor(m / cell_m + 0.5f)) % size;
    return static_cast<size_t>(cell < 0 ? cell + size : cell);
  };
  return wrapped(at.y()) * size + wrapped(at.x());
}

}  // namespace

void BlurPlane(int size, std::vector<float>* plane) {
  for (const bool along_x : {true, false}) {
    const std::vector<float> source = *plane;
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const auto at = [&](int by) {
          const int u = along_x ? (x + by + size) % size : x;
          const int v = along_x ? y : (y + by + size) % size;
          return source[static_cast<size_t>(v) * size + u];
        };
        (*plane)[static_cast<size_t>(y) * size + x] = at(0) + 0.5f * (at(-1) + at(1));
      }
    }
  }
}

PlanImage MakeReference(const SessionPlan& plan, int size) {
  PlanImage image = MakeEmpty(size);
  auto& [x, y, wall, free, blocking] = image.planes;
  for (const SessionPlan::Wall& w : plan.walls) {
    const size_t i = IndexOf(w.position - plan.center, plan.cell_m, size);
    x[i] = w.normal.x();
    y[i] = w.normal.y();
    wall[i] = w.weight;
    blocking[i] = w.blocks ? -1.0f : 0.0f;
  }
  for (auto* plane : {&x, &y, &wall}) BlurPlane(size, plane);
  for (size_t i = 0; i < wall.size(); ++i) {
    // A long wall's cells add up in the blur: cut back to the worth of one.
    const float length = std::max(1.0f, std::hypot(x[i], y[i]));
    x[i] /= length;
    y[i] /= length;
    wall[i] = kPlanUnoriented * std::min(wall[i], 1.0f);
  }
  for (size_t i = 0; i < plan.free.size(); ++i) {
    if (plan.free[i]) free[IndexOf(plan.FreeCenter(i) - plan.center, plan.cell_m, size)] = -1;
  }
  return image;
}

PlanImage MakeMoved(const SessionPlan& plan, double yaw, int size) {
  PlanImage image = MakeEmpty(size);
  auto& [x, y, wall, free, blocking] = image.planes;
  const Eigen::Matrix2f R = Eigen::Rotation2Df(static_cast<float>(yaw)).toRotationMatrix();
  for (const SessionPlan::Wall& w : plan.walls) {
    const size_t i = IndexOf(R * (w.position - plan.center), plan.cell_m, size);
    const Eigen::Vector2f normal = R * w.normal;
    x[i] += normal.x();
    y[i] += normal.y();
    wall[i] += w.weight;
    free[i] += w.blocks ? 1.0f : 0.0f;  // Correlates with the reference's free cells.
  }
  for (size_t i = 0; i < plan.free.size(); ++i) {
    if (plan.free[i]) {
      blocking[IndexOf(R * (plan.FreeCenter(i) - plan.center), plan.cell_m, size)] += 1;
    }
  }
  return image;
}

}  // namespace isthmus::matching
