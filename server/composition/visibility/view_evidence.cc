#include "server/composition/visibility/view_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/composition/limits.h"
#include "server/composition/visibility/limits.h"

namespace isthmus::composition {
namespace {

constexpr int kRanges = static_cast<int>(kFarthestLookM) + 1;  // Math: whole metres.

int32_t ToSteps(float log_odds) {
  return static_cast<int32_t>(std::lround(log_odds / kLogOddsStep));
}

// Log odds, in steps, of a look that finds something. If a thing could hide between rays, a find
// says as little as a look through.
int32_t On(int32_t through) {
  static const int32_t most = ToSteps(std::log(kOnIfThere / kOnIfGone));
  return std::min(most, -through);
}

// Log odds, in steps, of a look through, by whole metres of the point's range.
std::array<int32_t, kRanges> ThroughByRange() {
  std::array<int32_t, kRanges> steps;
  for (int i = 0; i < kRanges; ++i) {
    const float hidden = 1 - kThingM / (kGapRad * (static_cast<float>(i) + 0.5f));
    steps[i] = ToSteps(std::log(std::max(kThroughIfThere, hidden) / kThroughIfGone));
  }
  return steps;
}

Eigen::Vector3f Position(const WeightedPoint& p) { return {p.x, p.y, p.z}; }

}  // namespace

ViewEvidence::ViewEvidence(std::span<const WeightedPoint> points) : points_(points) {
  for (size_t begin = 0; begin < points.size(); begin += kGroupPoints) {
    Group group{begin, std::min(points.size(), begin + kGroupPoints), {}, 0};
    Eigen::Vector3f low = Position(points[begin]), high = low;
    for (size_t i = begin; i < group.end; ++i) {
      low = low.cwiseMin(Position(points[i]));
      high = high.cwiseMax(Position(points[i]));
    }
    group.center = 0.5f * (low + high);
    group.radius = 0.5f * (high - low).norm();
    groups_.push_back(group);
  }
}

void ViewEvidence::LookAt(const Group& group, const RangeImage& image, const Asking& asking,
                          std::vector<int32_t>* log_odds) const {
  static const std::array<int32_t, kRanges> through = ThroughByRange();
  for (size_t i = group.begin; i < group.end; ++i) {
    const Eigen::Vector3f p =
        asking.R_sensor_points * Position(points_[i]) + asking.t_sensor_points;
    const float range2 = p.squaredNorm();
    if (!(range2 >= kNearestLookM * kNearestLookM && range2 < kFarthestLookM * kFarthestLookM))
      continue;
    if (points_[i].keyframe == asking.not_keyframe) continue;
    RangeImage::Interval seen;
    if (!image.At(p, &seen)) continue;
    const float range = std::sqrt(range2), margin = asking.margin_m + asking.margin_per_m * range;
    const float slant = p.head<2>().norm() / std::max(kHorizonSine * range, std::abs(p.z()));
    const float behind = margin + kBesideRad * range * slant;
    const int32_t through_at = through[static_cast<size_t>(range)];
    if (range < seen.shortest - behind) {
      (*log_odds)[i] += through_at;
    } else if (std::abs(range - seen.shortest) < margin ||
               std::abs(range - seen.longest) < margin) {
      (*log_odds)[i] += On(through_at);
    }
  }
}

bool ViewEvidence::Look(const SubmapViews& views, const Pose& T_views_points, bool are_placed,
                        const KeepOn& keep_on, std::vector<int32_t>* log_odds) const {
  log_odds->assign(points_.size(), 0);
  Asking asking;
  asking.margin_m = kBehindM + (are_placed ? kPlacementM : 0);
  asking.margin_per_m = kBehindPerM + (are_placed ? kPlacementRad : 0);
  const Pose T_points_views = T_views_points.Inverse();
  const size_t count = views.views.size(), most = are_placed ? kAskedViews : kMostViews;
  const size_t step = std::max<size_t>(1, (count + most - 1) / most);
  size_t looked = 0;
  for (size_t k = 0; k < count; k += step) {
    const View& view = views.views[k];
    const Pose T_sensor_points = view.T_submap_sensor.Inverse() * T_views_points;
    asking.R_sensor_points = T_sensor_points.RotationMatrix().cast<float>();
    asking.t_sensor_points = T_sensor_points.translation().cast<float>();
    if (!are_placed) asking.not_keyframe = view.keyframe;
    const Eigen::Vector3f sensor =
        (T_points_views * view.T_submap_sensor.translation()).cast<float>();
    for (const Group& group : groups_) {
      const float reach = kFarthestLookM + group.radius;
      if (!((group.center - sensor).squaredNorm() < reach * reach)) continue;
      LookAt(group, view.image, asking, log_odds);
      if (++looked % (kPointsAtOnce / kGroupPoints) == 0 && !keep_on()) return false;
    }
  }
  return true;
}

}  // namespace isthmus::composition
