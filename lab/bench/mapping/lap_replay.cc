#include "lab/bench/mapping/lap_replay.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <utility>

#include "lab/bench/mapping/map_truth.h"

namespace isthmus::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kAwayM = 8;  // Farther than this counts as having gone away, ...
constexpr double kBackM = 5;  // ... nearer than this, heading alike, as having come back.
constexpr double kAlike = 30 * kDegree;

struct Lap {
  size_t begin = 0, end = 0;
  double gap_m = std::numeric_limits<double>::infinity();
};

// The first return of the submaps from `begin` on, and how near it is.
Lap ComeBack(const std::vector<Pose>& truth, size_t begin) {
  Lap lap{begin, begin};
  bool away = false;
  for (size_t i = begin + 1; i < truth.size(); ++i) {
    const double gap = (truth[i].translation() - truth[begin].translation()).norm();
    away |= gap > kAwayM;
    const bool alike = RotationAngle(truth[begin].Inverse() * truth[i]) < kAlike;
    if (!away || !alike || gap >= std::min(lap.gap_m, kBackM)) {
      if (lap.gap_m < kBackM) break;
      continue;
    }
    lap.end = i;
    lap.gap_m = gap;
  }
  return lap;
}

}  // namespace

absl::StatusOr<LapReplay> LapReplay::Create(const DrivenRobot& robot,
                                            const ReplayOptions& options) {
  std::vector<Pose> truth;
  for (const auto& submap : robot.submaps) truth.push_back(bench::TruePose(robot, *submap));
  Lap best;
  for (size_t begin = 0; begin < truth.size(); ++begin) {
    const Lap lap = ComeBack(truth, begin);
    if (lap.gap_m < best.gap_m) best = lap;
  }
  if (best.end == best.begin) {
    return absl::FailedPreconditionError("the drive does not come back to where it has been");
  }
  return LapReplay(robot, best.begin, best.end, options);
}

LapReplay::LapReplay(const DrivenRobot& robot, size_t begin, size_t end,
                     const ReplayOptions& options)
    : options_(options),
      random_(options.seed, 0x1A, 0),
      lap_(robot.submaps.begin() + static_cast<std::ptrdiff_t>(begin),
           robot.submaps.begin() + static_cast<std::ptrdiff_t>(end)),
      lap_ns_(robot.submaps[end]->first_stamp_ns - robot.submaps[begin]->first_stamp_ns) {
  for (const auto& submap : lap_) truth_.push_back(bench::TruePose(robot, *submap));
}

Pose LapReplay::Step(size_t from) const {
  if (from + 1 == lap_.size()) return truth_[from].Inverse() * truth_[0];
  return lap_[from]->T_odom_submap.Inverse() * lap_[from + 1]->T_odom_submap;
}

Submap LapReplay::Next() {
  const size_t at = next_ % lap_.size(), lap = next_ / lap_.size();
  const Submap& recorded = *lap_[at];
  Submap submap = recorded;
  submap.id.index = next_++;
  submap.T_odom_submap = T_odom_next_;
  const int64_t later_ns = static_cast<int64_t>(lap) * lap_ns_;
  submap.first_stamp_ns += later_ns;
  submap.last_stamp_ns += later_ns;
  for (Keyframe& keyframe : submap.keyframes) keyframe.stamp_ns += later_ns;
  const size_t count = recorded.points.size();
  const size_t one_in =
      options_.max_points == 0 ? 1 : (count + options_.max_points - 1) / options_.max_points;
  submap.points.clear();
  for (size_t i = 0; i < count; i += std::max<size_t>(1, one_in)) {
    SubmapPoint point = recorded.points[i];
    point.x += static_cast<float>(options_.noise_m * random_.Normal());
    point.y += static_cast<float>(options_.noise_m * random_.Normal());
    point.z += static_cast<float>(options_.noise_m * random_.Normal());
    submap.points.push_back(point);
  }
  const Pose step = Step(at);
  T_odom_next_ = T_odom_next_ * step * DriftOf(options_.drift, step.translation().norm(), random_);
  return submap;
}

}  // namespace isthmus::bench
