#include "lab/bench/mapping/map_truth.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <numbers>
#include <optional>
#include <utility>

#include "client/evaluation/trajectory_error.h"
#include "lab/bench/merging/figures.h"

namespace isthmus::bench {
namespace {

constexpr double kFalseM = 0.5, kFalseDeg = 2;

const ScanPose& PoseOf(const DrivenRobot& robot, const Keyframe& keyframe) {
  return *robot.FindPose(keyframe.sequence);
}

// T_frame_sensor of every keyframe, where `frame_of` says how submaps lie in the frame.
template <typename FrameOf>
Trajectory Keyframes(const DrivenRobot& robot, const FrameOf& frame_of) {
  Trajectory poses;
  for (const auto& submap : robot.submaps) {
    for (const Keyframe& keyframe : submap->keyframes) {
      poses.push_back({keyframe.stamp_ns, frame_of(*submap, keyframe)});
    }
  }
  return poses;
}

struct OffTruth {
  double metres = 0, degrees = 0;

  bool IsFalse() const { return metres > kFalseM || degrees > kFalseDeg; }
};

OffTruth ErrorOf(const Pose& T_a_b, uint32_t a, uint32_t b, const DrivenRobot& robot) {
  const Pose T_true =
      TruePose(robot, *robot.submaps.at(a)).Inverse() * TruePose(robot, *robot.submaps.at(b));
  const Pose error = T_true.Inverse() * T_a_b;
  return {error.translation().norm(), RotationAngle(error) * 180 / std::numbers::pi};
}

absl::StatusOr<TeamRmse> RmseOf(const std::vector<evaluation::TrajectoryPair>& team,
                                const std::vector<uint32_t>& components) {
  for (size_t i = 0; i < team.size(); ++i) {
    if (components[i] == components[0]) continue;
    return absl::FailedPreconditionError(
        absl::StrCat("robot ", team[i].name, " is in a component of its own"));
  }
  const auto errors = evaluation::CompareTrajectories(team);
  if (!errors.ok()) return errors.status();
  TeamRmse rmse = {errors->all.rmse_m, {}};
  for (const auto& of_robot : errors->robots) rmse.robots_m.push_back(of_robot.rmse_m);
  return rmse;
}

}  // namespace

Pose TruePose(const DrivenRobot& robot, const Submap& submap) {
  return PoseOf(robot, submap.keyframes.front()).T_world_sensor;
}

Trajectory TrueKeyframes(const DrivenRobot& robot) {
  return Keyframes(robot, [&](const Submap&, const Keyframe& keyframe) {
    return PoseOf(robot, keyframe).T_world_sensor;
  });
}

Trajectory OdometryKeyframes(const DrivenRobot& robot) {
  return Keyframes(robot, [](const Submap& submap, const Keyframe& keyframe) {
    return submap.T_odom_submap * keyframe.T_submap_sensor;
  });
}

absl::StatusOr<double> OpenLoopRmse(const DrivenRobot& robot) {
  const auto errors = evaluation::CompareTrajectories(
      {{robot.session.robot.value(), TrueKeyframes(robot), OdometryKeyframes(robot)}});
  if (!errors.ok()) return errors.status();
  return errors->all.rmse_m;
}

absl::StatusOr<TeamRmse> TrajectoryRmse(const std::vector<DrivenRobot>& robots,
                                        server::Pipeline& pipeline) {
  std::vector<evaluation::TrajectoryPair> team;
  std::vector<uint32_t> components;
  for (const DrivenRobot& robot : robots) {
    const RobotId& name = robot.session.robot;
    const auto in_map = pipeline.reader().GetTrajectory(name, TrajectoryFrame::kMap);
    if (!in_map.ok()) return in_map.status();
    components.push_back(in_map->component);
    team.push_back({name.value(), TrueKeyframes(robot), in_map->poses});
  }
  return RmseOf(team, components);
}

absl::StatusOr<TeamRmse> MapRmse(const std::vector<DrivenRobot>& robots,
                                 server::Pipeline& pipeline) {
  const SubmapPlaces places = PlacesOf(pipeline);
  std::vector<evaluation::TrajectoryPair> team;
  std::vector<uint32_t> components;
  for (const DrivenRobot& robot : robots) {
    const auto newest = places.find(robot.submaps.back()->id);
    if (newest == places.end()) return absl::FailedPreconditionError("a submap has no place");
    components.push_back(newest->second.component);
    team.push_back(
        {robot.session.robot.value(), TrueKeyframes(robot), PlacedKeyframes(robot, places)});
  }
  return RmseOf(team, components);
}

SubmapPlaces PlacesOf(server::Pipeline& pipeline) {
  SubmapPlaces places;
  const auto submaps = pipeline.reader().ListSubmaps(std::nullopt);
  if (!submaps.ok()) return places;
  for (const SubmapStatus& submap : *submaps) {
    if (submap.component) places[submap.info.id] = {*submap.component, submap.T_map_submap};
  }
  return places;
}

Trajectory PlacedKeyframes(const DrivenRobot& robot, const SubmapPlaces& places) {
  Trajectory poses;
  for (const auto& submap : robot.submaps) {
    const auto it = places.find(submap->id);
    if (it == places.end()) continue;
    for (const Keyframe& keyframe : submap->keyframes) {
      poses.push_back({keyframe.stamp_ns, it->second.T_map_submap * keyframe.T_submap_sensor});
    }
  }
  return poses;
}

LoopFigures JudgeLoops(const std::vector<Loop>& loops, const std::vector<DrivenRobot>& robots) {
  LoopFigures figures;
  std::vector<double> metres, degrees;
  for (const Loop& status : loops) {
    const LoopClosure& loop = status.loop;
    const auto robot = std::find_if(robots.begin(), robots.end(), [&](const DrivenRobot& r) {
      return r.session.id == loop.session;
    });
    if (robot == robots.end()) continue;
    const OffTruth off = ErrorOf(loop.T_a_b, loop.submap_a, loop.submap_b, *robot);
    metres.push_back(off.metres);
    degrees.push_back(off.degrees);
    ++figures.loops;
    figures.false_loops += off.IsFalse();
    figures.false_used += off.IsFalse() && status.edges_used > 0;
    if (!off.IsFalse()) {
      figures.worst_m = std::max(figures.worst_m, off.metres);
      figures.worst_deg = std::max(figures.worst_deg, off.degrees);
    }
    for (const SubmapEdge& edge : loop.edges) {
      ++figures.edges;
      figures.false_edges += ErrorOf(edge.T_a_b, edge.submap_a, edge.submap_b, *robot).IsFalse();
    }
  }
  figures.median_m = Median(std::move(metres));
  figures.median_deg = Median(std::move(degrees));
  return figures;
}

}  // namespace isthmus::bench
