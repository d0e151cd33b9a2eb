// The grid that a session's plan is drawn on.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cstdint>
#include <vector>

#include "core/geometry/range_image.h"
#include "core/pose.h"
#include "server/matching/index/limits.h"
#include "server/matching/index/session_plan.h"
#include "server/matching/registration/surface.h"
#include "server/matching/search/ground_grid.h"

namespace isthmus::matching {

// Everything in the level frame.
class PlanGrid {
 public:
  // As far as a plan reaches from where the sensors were.
  explicit PlanGrid(const std::vector<Eigen::Vector3f>& sensors);

  void DrawWalls(const std::vector<SurfacePoint>& surface, const GroundGrid& ground,
                 const std::vector<Eigen::Vector3f>& sensors);
  // Marks the cells that the view looked across as free.
  void DrawFree(const RangeImage& image, const Pose& T_level_sensor, const GroundGrid& ground);

  SessionPlan Plan() const;

 private:
  struct Cell {
    Eigen::Vector2f normal = Eigen::Vector2f::Zero();  // Sum.
    uint16_t count = 0, layers = 0;
    uint8_t hits = 0;

    bool Blocks() const {
      return std::popcount(layers & ((1u << kLowLayers) - 1)) >= kBlockingLayers;
    }
  };

  // Null outside.
  Cell* At(const Eigen::Vector2f& position);
  bool IsNearBlocking(int x, int y) const;

  Eigen::Vector2f origin_ = Eigen::Vector2f::Zero();
  float cell_m_ = kPlanCellM;
  int width_ = 0, rows_ = 0;
  std::vector<Cell> cells_;
};

}  // namespace isthmus::matching
