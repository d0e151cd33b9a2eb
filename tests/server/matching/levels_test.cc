// Decks above each other share walls and columns, but no floor: nothing to hold on to.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "lab/simulation/wild/wild.h"
#include "server/matching/pairs/joint_refinement.h"

namespace isthmus::matching {
namespace {

constexpr int kScansPerKeyframe = 15, kKeyframesPerSubmap = 5, kOneIn = 2;

// The points of a scan as seen from where it ended.
void AddKeyframe(const simulation::Simulator& simulator, int scan_index, Submap* submap) {
  const Scan scan = simulator.MakeScan(0, scan_index);
  const double end_s = (scan_index + 1) * simulator.lidar().period_s;
  const Pose T_submap_world = submap->T_odom_submap.Inverse();
  const auto keyframe = static_cast<uint16_t>(submap->keyframes.size());
  submap->keyframes.push_back(
      {scan.sequence, scan.end_stamp_ns, T_submap_world * simulator.PoseAt(0, end_s)});
  for (size_t i = 0; i < scan.points.size(); i += kOneIn) {
    const ScanPoint& point = scan.points[i];
    const Pose T_submap_sensor = T_submap_world * simulator.PoseAt(0, end_s + point.time);
    const Eigen::Vector3d p = T_submap_sensor * Eigen::Vector3d(point.x, point.y, point.z);
    SubmapPoint& added = submap->points.emplace_back();
    added.x = static_cast<float>(p.x());
    added.y = static_cast<float>(p.y());
    added.z = static_cast<float>(p.z());
    added.keyframe = keyframe;
  }
}

// A robot of a car park of several decks, with an odometry that does not err: odom is the world.
SessionMap MapOf(int robot, const std::string& sensor) {
  simulation::WildTeam team;
  team.kind = "carpark";
  team.sensor = sensor;
  team.robots = 4;
  const auto drive = simulation::DrawWildTeamDrive(9501, team, robot);
  SessionMap map;
  map.session = SessionId("robot-" + std::to_string(robot));
  if (!drive.ok()) return map;
  const simulation::Simulator& simulator = *drive->simulator;
  std::shared_ptr<Submap> submap;
  for (int i = 0; i < simulator.scan_count(); i += kScansPerKeyframe) {
    if (!submap || submap->keyframes.size() == kKeyframesPerSubmap) {
      submap = std::make_shared<Submap>();
      submap->id = {map.session, static_cast<uint32_t>(map.submaps.size())};
      submap->T_odom_submap = simulator.PoseAt(0, (i + 1) * simulator.lidar().period_s);
      map.submaps.push_back(submap);
    }
    AddKeyframe(simulator, i, submap.get());
  }
  return map;
}

// One drives on the upper deck and down the ramp in the end, the other on the lower deck.
TEST(Levels, DecksAboveEachOtherBendNoMap) {
  const SessionMap map_a = MapOf(0, "hdl32"), map_b = MapOf(2, "os1-32");
  const PreparedMap a(map_a), b(map_b);
  JointRefinement joint{MapPoses::Rigid(map_a, map_b, Pose()), {}, 0, Pose()};
  ASSERT_TRUE(RefineJointly(a, b, 1.0, 0, 0, &joint));
  EXPECT_GE(joint.edges.size(), 4u);
  for (const SubmapEdge& edge : joint.edges) {
    const Pose truth = map_a.submaps[edge.submap_a]->T_odom_submap.Inverse() *
                       map_b.submaps[edge.submap_b]->T_odom_submap;
    EXPECT_LT((truth.Inverse() * edge.T_a_b).translation().norm(), 0.2)
        << edge.submap_a << " ~ " << edge.submap_b;
  }
  for (size_t k = 0; k < map_a.submaps.size(); ++k) {
    const Pose moved = map_a.submaps[k]->T_odom_submap.Inverse() * joint.poses.a[k];
    EXPECT_LT(moved.translation().norm(), 0.05) << k;
  }
}

}  // namespace
}  // namespace isthmus::matching
