#include "client/evaluation/evaluation.h"

#include <numbers>
#include <utility>

namespace isthmus::evaluation {
namespace {

EvaluatedTrajectory EvaluateOne(const TrajectoryPair& pair, const Pose& T_truth_estimate,
                                const ErrorStatistics& absolute, const EvaluationOptions& options) {
  EvaluatedTrajectory out;
  out.name = pair.name;
  out.truth = pair.truth;
  out.estimate_poses = pair.estimate.size();
  out.pairs = Associate(pair.truth, pair.estimate, options.tolerance_s);
  for (PosePair& poses : out.pairs) poses.estimate = T_truth_estimate * poses.estimate;
  out.way_m = WayAlongTruth(out.pairs).back();
  out.duration_s =
      1e-9 * static_cast<double>(out.pairs.back().stamp_ns - out.pairs.front().stamp_ns);
  out.T_truth_estimate = T_truth_estimate;
  out.absolute = absolute;
  out.per_frame = CompareSteps(out.pairs, {1, DeltaUnit::kFrames});
  out.per_delta = CompareSteps(out.pairs, options.delta);
  out.drift = CompareSegments(out.pairs);
  return out;
}

}  // namespace

absl::StatusOr<Evaluation> Evaluate(const std::vector<TrajectoryPair>& pairs,
                                    const EvaluationOptions& options) {
  Evaluation out{options, {}, std::nullopt};
  if (options.merged) {
    const auto errors = CompareTrajectories(pairs, options.alignment, options.tolerance_s);
    if (!errors.ok()) return errors.status();
    out.all = errors->all;
    for (size_t i = 0; i < pairs.size(); ++i) {
      out.robots.push_back(
          EvaluateOne(pairs[i], errors->T_truth_estimate, errors->robots[i], options));
    }
    return out;
  }
  for (const TrajectoryPair& pair : pairs) {
    const auto errors = CompareTrajectories({pair}, options.alignment, options.tolerance_s);
    if (!errors.ok()) return errors.status();
    out.robots.push_back(EvaluateOne(pair, errors->T_truth_estimate, errors->all, options));
  }
  if (pairs.empty()) return CompareTrajectories(pairs).status();
  return out;
}

double PositionError(const PosePair& pair) {
  return (pair.truth.translation() - pair.estimate.translation()).norm();
}

double RotationErrorDeg(const PosePair& pair) {
  return RotationAngle(pair.truth.Inverse() * pair.estimate) * 180 / std::numbers::pi;
}

}  // namespace isthmus::evaluation
