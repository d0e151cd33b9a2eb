#include "server/matching/prepared/low_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/matching/prepared/limits.h"
#include "server/matching/registration/voxel_key.h"

namespace isthmus::matching {
namespace {

// Cells of a stretch, and how many of them may be empty.
constexpr int kWallSteps = static_cast<int>(kWallM / kThingVoxelM);                    // Math.
constexpr int kMostWallGaps = static_cast<int>((1 - kWallFilled) * (kWallSteps + 1));  // Math.

uint64_t PlanCellAt(const Eigen::Vector2f& p, int storey) {
  const float z = kThingVoxelM * (static_cast<float>(storey) + 0.5f);
  return VoxelKey({p.x(), p.y(), z}, 1 / kThingVoxelM);
}

// Calls for the cell of p and the eight around it.
template <typename Do>
void ForCellsAround(const Eigen::Vector2f& p, int storey, const Do& call) {
  for (const float x : {-kThingVoxelM, 0.0f, kThingVoxelM}) {
    for (const float y : {-kThingVoxelM, 0.0f, kThingVoxelM}) {
      const Eigen::Vector2f at = p + Eigen::Vector2f(x, y);
      call(at, PlanCellAt(at, storey));
    }
  }
}

}  // namespace

void LowPlan::Add(const Eigen::Vector2f& p, int storey, float height_m) {
  const uint64_t cell = PlanCellAt(p, storey);
  Heights& heights = cells_.try_emplace(cell, Heights{height_m, height_m}).first->second;
  const bool stood = heights.highest - heights.lowest > kUprightM;
  heights.lowest = std::min(heights.lowest, height_m);
  heights.highest = std::max(heights.highest, height_m);
  if (stood || heights.highest - heights.lowest <= kUprightM) return;
  ForCellsAround(p, storey, [&](const auto&, uint64_t key) { upright_.insert(key); });
}

bool LowPlan::IsAtWall(const Eigen::Vector2f& p, int storey) const {
  bool at_wall = false;
  ForCellsAround(p, storey, [&](const Eigen::Vector2f& at, uint64_t key) {
    at_wall = at_wall || (cells_.contains(key) && IsOfWall(at, storey));
  });
  return at_wall;
}

bool LowPlan::IsOfWall(const Eigen::Vector2f& p, int storey) const {
  for (int i = 0; i < kWallDirections; ++i) {
    const double angle = std::numbers::pi * i / kWallDirections;
    const Eigen::Vector2f along(std::cos(angle), std::sin(angle));
    for (const int first : {-kWallSteps, -kWallSteps / 2, 0}) {
      if (IsFilled(p, along, first, storey)) return true;
    }
  }
  return false;
}

bool LowPlan::IsFilled(const Eigen::Vector2f& p, const Eigen::Vector2f& along, int first,
                       int storey) const {
  int gaps = 0;
  for (int k = first; k <= first + kWallSteps; ++k) {
    const Eigen::Vector2f at = p + static_cast<float>(k) * kThingVoxelM * along;
    if (!upright_.contains(PlanCellAt(at, storey)) && ++gaps > kMostWallGaps) return false;
  }
  return true;
}

}  // namespace isthmus::matching
