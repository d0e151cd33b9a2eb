#include "server/matching/index/plan_comparison.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "server/matching/index/limits.h"
#include "server/matching/index/plan_image.h"

namespace isthmus::matching {
namespace {

float CoarseCell(float radius, float least) {
  float cell_m = 2 * kPlanCellM;
  if (radius > kFineRadiusM) cell_m *= 2;
  for (float reach = kMiddleRadiusM; radius > reach; reach *= 2) cell_m *= 2;
  return std::max(cell_m, 2 * least);
}

// A plan's walls to be looked up, blurred.
class WallLookup {
 public:
  explicit WallLookup(const SessionPlan& plan)
      : inverse_cell_(1 / plan.cell_m), size_(static_cast<int>(2 * plan.radius / plan.cell_m) + 5) {
    origin_ = plan.center.array() - 0.5f * static_cast<float>(size_) * plan.cell_m;
    std::vector<float> x(static_cast<size_t>(size_) * size_, 0.0f), y = x, weight = x;
    for (const SessionPlan::Wall& wall : plan.walls) {
      const int i = IndexOf(wall.position);
      if (i < 0) continue;
      x[i] = wall.normal.x();
      y[i] = wall.normal.y();
      weight[i] = wall.weight;
    }
    for (auto* plane : {&x, &y, &weight}) BlurPlane(size_, plane);
    walls_.resize(x.size());
    for (size_t i = 0; i < x.size(); ++i) {
      const float length = std::max(1.0f, std::hypot(x[i], y[i]));
      walls_[i] = {x[i] / length, y[i] / length, kPlanUnoriented * std::min(weight[i], 1.0f)};
    }
  }

  float Agreement(const Eigen::Vector2f& at, const Eigen::Vector2f& normal, float weight) const {
    const int i = IndexOf(at);
    return i < 0 ? 0 : walls_[i].dot(Eigen::Vector3f(normal.x(), normal.y(), weight));
  }

 private:
  int IndexOf(const Eigen::Vector2f& position) const {
    const Eigen::Vector2f at = (position - origin_) * inverse_cell_;
    if (!(at.x() >= 0 && at.y() >= 0)) return -1;
    const int column = static_cast<int>(at.x()), row = static_cast<int>(at.y());
    return column < size_ && row < size_ ? row * size_ + column : -1;
  }

  float inverse_cell_;
  int size_;
  Eigen::Vector2f origin_;
  std::vector<Eigen::Vector3f> walls_;  // Normal; what does not depend on it.
};

// Two plans in cells of one size.
class PlanFit {
 public:
  PlanFit(const SessionPlan& a, const SessionPlan& b) : a_(a), b_(b), lookup_(a) {}

  // Every n-th cell of either is asked and counts n-fold, so that about `cells` are.
  double Score(const PlanarPose& placement, size_t cells) const {
    const Eigen::Rotation2Df R(static_cast<float>(placement.yaw));
    const Eigen::Vector2f shift = placement.shift.cast<float>();
    const size_t stride_b = std::max<size_t>(1, b_.walls.size() / cells);
    const size_t stride_a = std::max<size_t>(1, a_.walls.size() / cells);
    float of_b = 0, of_a = 0;
    for (size_t i = 0; i < b_.walls.size(); i += stride_b) {
      const SessionPlan::Wall& wall = b_.walls[i];
      const Eigen::Vector2f at = R * wall.position + shift;
      of_b += lookup_.Agreement(at, R * wall.normal, wall.weight);
      if (wall.blocks && a_.IsFree(at)) of_b -= 1;
    }
    const Eigen::Rotation2Df back = R.inverse();
    for (size_t i = 0; i < a_.walls.size(); i += stride_a) {
      const SessionPlan::Wall& wall = a_.walls[i];
      if (wall.blocks && b_.IsFree(back * (wall.position - shift))) of_a -= 1;
    }
    return static_cast<double>(stride_b) * of_b + static_cast<double>(stride_a) * of_a;
  }

  // From few cells of either; then by all cells.
  PlanarPose Polish(PlanarPose placement, double yaw_step, double shift_step) const {
    const auto score = [&](const PlanarPose& at, double) { return Score(at, kPolishCells); };
    placement.score = Score(placement, kPolishCells);
    placement =
        Climb(placement, b_.center.cast<double>(), yaw_step, shift_step, 0.4 * a_.cell_m, score);
    placement.score = Score(placement, a_.walls.size() + b_.walls.size());
    return placement;
  }

 private:
  const SessionPlan& a_;
  const SessionPlan& b_;
  const WallLookup lookup_;
};

}  // namespace

PlanarPose PlanComparer::PlaceOn(const SessionPlan& a, const std::stop_token& stop) {
  const SessionPlan& b = *plan_;
  const float fine_m = std::max(a.cell_m, b.cell_m);
  const float coarse_m = CoarseCell(std::max(a.radius, b.radius), fine_m);
  const std::vector<PlanarPose> peaks = correlator_.Correlate(a, coarse_m, kPlanPolished, stop);
  PlanarPose best;
  if (peaks.empty()) return best;
  const SessionPlan fine_a = Coarsen(a, fine_m), fine_b = Coarsen(b, fine_m);
  const PlanFit fit(fine_a, fine_b);
  for (const PlanarPose& peak : peaks) {
    if (stop.stop_requested()) return {};
    const PlanarPose polished = fit.Polish(peak, M_PI / kPlanYaws, 0.5 * coarse_m);
    if (polished.score > best.score) best = polished;
  }
  // In cells of the usual size, whatever these are.
  const double cells = std::pow(fine_m / kPlanCellM, 2.0);
  const double walls = cells * std::min(fine_a.Weight(), fine_b.Weight());
  best.score *= cells / std::pow(1 + walls, kPlanSizePower);
  return best;
}

}  // namespace isthmus::matching
