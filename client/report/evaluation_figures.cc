#include "client/report/evaluation_figures.h"

#include <utility>

#include "client/report/limits.h"

namespace isthmus::report {
namespace {

using cli::Json;
using evaluation::EvaluatedTrajectory;
using evaluation::Evaluation;
using evaluation::PosePair;

// A line from above: [[x ...], [y ...]].
template <typename Range, typename Position>
Json LineFromAbove(const Range& range, bool camera_frame, Position position) {
  std::vector<double> right, up;
  for (const auto& entry : range) {
    const Eigen::Vector3d p = position(entry);
    right.push_back(p.x());
    up.push_back(camera_frame ? p.z() : p.y());
  }
  return {Thinned(right, kFigurePoints), Thinned(up, kFigurePoints)};
}

Figure TrajectoriesFigure(const Evaluation& evaluation, bool camera_frame) {
  Figure figure = {{"file", "trajectories"},
                   {"kind", "trajectories"},
                   {"title", "Trajectories from above"},
                   {"axes", {"x", camera_frame ? "z" : "y"}},
                   {"series", Json::array()}};
  const Trajectory* before = nullptr;
  for (const EvaluatedTrajectory& robot : evaluation.robots) {
    // One truth of several estimates is drawn once.
    const bool is_new =
        before == nullptr || before->size() != robot.truth.size() ||
        before->front().pose.translation() != robot.truth.front().pose.translation();
    before = &robot.truth;
    figure["series"].push_back(
        {{"name", robot.name},
         {"truth_drawn", is_new},
         {"truth", LineFromAbove(robot.truth, camera_frame,
                                 [](const StampedPose& p) { return p.pose.translation(); })},
         {"estimate", LineFromAbove(robot.pairs, camera_frame,
                                    [](const PosePair& p) { return p.estimate.translation(); })}});
  }
  return figure;
}

Figure ErrorFigure(const Evaluation& evaluation) {
  Figure figure = {{"file", "error"},
                   {"kind", "error"},
                   {"title", "Error over distance"},
                   {"series", Json::array()}};
  for (const EvaluatedTrajectory& robot : evaluation.robots) {
    std::vector<double> m, deg;
    for (const PosePair& pair : robot.pairs) {
      m.push_back(evaluation::PositionError(pair));
      deg.push_back(evaluation::RotationErrorDeg(pair));
    }
    figure["series"].push_back(
        {{"name", robot.name},
         {"way_m", Thinned(evaluation::WayAlongTruth(robot.pairs), kFigurePoints)},
         {"error_m", Thinned(m, kFigurePoints)},
         {"error_deg", Thinned(deg, kFigurePoints)}});
  }
  return figure;
}

// Null where no drive has a segment.
Figure DriftFigure(const Evaluation& evaluation) {
  Figure figure = {{"file", "rpe"},
                   {"kind", "drift"},
                   {"title", "Relative error by length of segment"},
                   {"series", Json::array()}};
  bool is_empty = true;
  for (const EvaluatedTrajectory& robot : evaluation.robots) {
    Json lengths = Json::array();
    for (const evaluation::SegmentErrors& errors : robot.drift.lengths) {
      lengths.push_back({{"length_m", errors.length_m},
                         {"percent", Thinned(errors.percent, kBoxValues)},
                         {"deg_per_100m", Thinned(errors.deg_per_100m, kBoxValues)}});
    }
    is_empty = is_empty && lengths.empty();
    figure["series"].push_back({{"name", robot.name}, {"lengths", std::move(lengths)}});
  }
  return is_empty ? Figure(nullptr) : figure;
}

Figure TimingFigure(const std::vector<TimingFile>& timing) {
  Figure figure = {{"file", "timing"},
                   {"kind", "timing"},
                   {"title", "Time per stage"},
                   {"series", Json::array()}};
  for (const TimingFile& file : timing) {
    Json stages = Json::array();
    for (const StageColumn& stage : file.stages) {
      stages.push_back({{"name", stage.name}, {"ms", stage.ms}});
    }
    figure["series"].push_back({{"name", file.name},
                                {"scan", file.scans},
                                {"stages", std::move(stages)},
                                {"total_ms", file.total_ms},
                                {"tracking", file.tracking}});
  }
  return figure;
}

}  // namespace

std::vector<double> Thinned(const std::vector<double>& values, size_t most) {
  if (values.size() <= most) return values;
  std::vector<double> out;
  const size_t step = (values.size() + most - 1) / most;
  for (size_t i = 0; i < values.size(); i += step) out.push_back(values[i]);
  out.push_back(values.back());
  return out;
}

std::vector<Figure> FiguresOf(const Evaluation& evaluation, bool camera_frame,
                              const std::vector<TimingFile>& timing) {
  std::vector<Figure> figures = {TrajectoriesFigure(evaluation, camera_frame),
                                 ErrorFigure(evaluation)};
  if (Figure drift = DriftFigure(evaluation); !drift.is_null()) figures.push_back(std::move(drift));
  if (!timing.empty()) figures.push_back(TimingFigure(timing));
  return figures;
}

}  // namespace isthmus::report
