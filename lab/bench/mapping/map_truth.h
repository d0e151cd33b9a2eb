// The truth that a map of uploaded submaps is compared with.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <vector>

#include "core/map/trajectory.h"
#include "lab/bench/merging/driven_robot.h"
#include "server/pipeline.h"

namespace isthmus::bench {

// The true pose of the submap's frame: the sensor at its first keyframe. The scan must not have
// been lost.
Pose TruePose(const DrivenRobot& robot, const Submap& submap);

// The sensor at every keyframe, in truth and as odometry alone has it.
Trajectory TrueKeyframes(const DrivenRobot& robot);
Trajectory OdometryKeyframes(const DrivenRobot& robot);

// RMSE of positions after one rigid alignment of all robots, m.
struct TeamRmse {
  double all_m = 0;
  std::vector<double> robots_m;  // Each in the alignment of all.
};
// As odometry alone has one robot.
absl::StatusOr<double> OpenLoopRmse(const DrivenRobot& robot);
// As the map has the ways of the robots' newest sessions: bent to follow the submaps, so that what
// odometry erred by between two submaps is shared out over the first. FailedPrecondition if they
// are not in one component.
absl::StatusOr<TeamRmse> TrajectoryRmse(const std::vector<DrivenRobot>& robots,
                                        server::Pipeline& pipeline);
// The same for the submaps in the map: each keyframe lies where its submap does, as points are
// placed.
absl::StatusOr<TeamRmse> MapRmse(const std::vector<DrivenRobot>& robots,
                                 server::Pipeline& pipeline);

// The place of a submap in the map.
struct SubmapPlace {
  uint32_t component = 0;
  Pose T_map_submap;
};
using SubmapPlaces = std::map<SubmapId, SubmapPlace>;
SubmapPlaces PlacesOf(server::Pipeline& pipeline);
// The keyframes of the robot's submaps that have a place.
Trajectory PlacedKeyframes(const DrivenRobot& robot, const SubmapPlaces& places);

// Loop closures against the truth of the robots that they are of.
struct LoopFigures {
  int loops = 0, edges = 0;
  int false_loops = 0;                  // More than 0.5 m or 2 degrees off, ...
  int false_edges = 0;                  // ... likewise edges, ...
  int false_used = 0;                   // ... and false loops with edges that the map agrees with.
  double worst_m = 0, worst_deg = 0;    // Loops that are not false.
  double median_m = 0, median_deg = 0;  // All loops.
};
LoopFigures JudgeLoops(const std::vector<Loop>& loops, const std::vector<DrivenRobot>& robots);

}  // namespace isthmus::bench
