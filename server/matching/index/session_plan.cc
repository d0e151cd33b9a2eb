#include "server/matching/index/session_plan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "server/matching/index/limits.h"
#include "server/matching/index/plan_grid.h"
#include "server/matching/search/gravity.h"
#include "server/matching/search/limits.h"
#include "server/matching/search/up_candidates.h"
#include "server/matching/search/wall_map.h"

namespace isthmus::matching {
namespace {

// R_level_odom. A ceiling is told from a floor by where odom's z points.
Eigen::Quaterniond Level(const PreparedSubmaps& submaps,
                         const std::vector<Eigen::Vector3f>& sensors) {
  double voxel_m = 2 * kPlanCellM;
  const std::vector<SurfacePoint> surface = JoinSurfaces(submaps, kPlanLevelPoints, &voxel_m);
  for (const UpCandidate& candidate : FindUpCandidates(surface, sensors)) {
    Eigen::Vector3d up = candidate.R_level_odom.inverse() * Eigen::Vector3d::UnitZ();
    if (up.z() < 0) up = -up;
    if (up.z() > std::cos(kMaxPlanTiltRad)) {
      return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
    }
  }
  return EstimateLevel(surface, kMaxPlanTiltRad);
}

}  // namespace

double SessionPlan::Weight() const {
  double sum = 0;
  for (const Wall& wall : walls) sum += wall.weight;
  return sum;
}

bool SessionPlan::IsFree(const Eigen::Vector2f& position) const {
  const Eigen::Vector2f at = (position - origin) / cell_m;
  if (!(at.x() >= 0 && at.y() >= 0)) return false;
  const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
  return x < width && y < rows && free[static_cast<size_t>(y) * width + x];
}

SessionPlan MakeSessionPlan(const PreparedSubmaps& submaps) {
  std::vector<Eigen::Vector3f> sensors;
  for (const auto& submap : submaps) AddSensorPositions(submap->submap(), &sensors);
  const Pose T_level_odom(Level(submaps, sensors), Eigen::Vector3d::Zero());
  const Eigen::Matrix3f R = T_level_odom.RotationMatrix().cast<float>();
  double voxel_m = kPlanCellM;
  std::vector<SurfacePoint> surface = JoinSurfaces(submaps, 0, &voxel_m);
  for (SurfacePoint& point : surface) {
    point.position = R * point.position;
    point.normal = R * point.normal;
  }
  for (Eigen::Vector3f& sensor : sensors) sensor = R * sensor;
  const GroundGrid ground(surface, kGroundCellM);
  PlanGrid grid(sensors);
  grid.DrawWalls(surface, ground, sensors);
  for (const auto& submap : submaps) {
    const Pose T_level_submap = T_level_odom * submap->submap().T_odom_submap;
    for (const PreparedSubmap::View& view : submap->views()) {
      grid.DrawFree(view.image, T_level_submap * view.T_submap_sensor, ground);
    }
  }
  return grid.Plan();
}

SessionPlan Coarsen(const SessionPlan& plan, float cell_m) {
  if (cell_m <= plan.cell_m) return plan;
  SessionPlan coarse;
  coarse.cell_m = cell_m;
  coarse.origin = plan.origin;
  coarse.width = static_cast<int>(static_cast<float>(plan.width) * plan.cell_m / cell_m) + 1;
  coarse.rows = static_cast<int>(static_cast<float>(plan.rows) * plan.cell_m / cell_m) + 1;
  coarse.center = plan.center;
  coarse.radius = plan.radius + cell_m;
  struct Sum {
    Eigen::Vector2f normal = Eigen::Vector2f::Zero();
    int walls = 0, free = 0;
    float weight = 0;
    bool blocks = false;
  };
  std::vector<Sum> sums(static_cast<size_t>(coarse.width) * coarse.rows);
  const auto at = [&](const Eigen::Vector2f& p) -> Sum& {
    const Eigen::Vector2f cell = (p - coarse.origin) / cell_m;
    const int x = std::clamp(static_cast<int>(cell.x()), 0, coarse.width - 1);
    const int y = std::clamp(static_cast<int>(cell.y()), 0, coarse.rows - 1);
    return sums[static_cast<size_t>(y) * coarse.width + x];
  };
  for (const SessionPlan::Wall& wall : plan.walls) {
    Sum& sum = at(wall.position);
    sum.normal += wall.normal;
    sum.weight = std::max(sum.weight, wall.weight);
    sum.blocks = sum.blocks || wall.blocks;
    ++sum.walls;
  }
  for (size_t i = 0; i < plan.free.size(); ++i) {
    if (plan.free[i]) ++at(plan.FreeCenter(i)).free;
  }
  coarse.free.resize(sums.size());
  const float fine_per_cell = std::pow(cell_m / plan.cell_m, 2.0f);
  for (size_t i = 0; i < sums.size(); ++i) {
    const Sum& sum = sums[i];
    if (sum.walls > 0) {
      const float length = std::max(sum.normal.norm(), 1e-6f);
      coarse.walls.push_back({coarse.FreeCenter(i),
                              std::min(length, sum.weight) / length * sum.normal, sum.weight,
                              sum.blocks});
    } else {
      coarse.free[i] = static_cast<float>(sum.free) > 0.4f * fine_per_cell;
    }
  }
  return coarse;
}

}  // namespace isthmus::matching
