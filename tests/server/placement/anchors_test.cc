// Submaps whose place is known from outside.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/server/placement/world.h"

namespace isthmus::placement {
namespace {

using Placements = std::vector<Placement>;

// The site's frame, in which anchors are given, seen from the frame of World's truth.
const Pose kSite = Pose::FromXyzRpy(200, -300, 12, 0, 0, 2);

class Anchors : public testing::Test {
 protected:
  Anchors() : world_(1) {
    world_.AddRobot("a-1", 100, 50, 40);
    for (int k = 50; k < 100; k += 3) world_.AddLoop("a-1", k - 50, k);
    before_ = Place();
  }

  const Placements& Place() {
    placements_ = placer_.Place(world_.input, placements_).placements;
    return placements_;
  }

  Anchor& AddAnchor(uint32_t index, double sigma_xy_m, double sigma_z_m, double sigma_deg) {
    Anchor anchor;
    anchor.submap = {SessionId("a-1"), index};
    anchor.T_map_submap = kSite * world_.Truth("a-1", index);
    anchor.sigma_xy_m = sigma_xy_m;
    anchor.sigma_z_m = sigma_z_m;
    anchor.sigma_deg = sigma_deg;
    world_.input.anchors.push_back(anchor);
    return world_.input.anchors.back();
  }

  double Off(uint32_t index) const {
    return (PoseOf(placements_, "a-1", index).translation() -
            kSite * world_.Truth("a-1", index).translation())
        .norm();
  }

  // The largest difference from the shape before.
  double Bend() const {
    const Pose T = PoseOf(placements_, "a-1", 0) * PoseOf(before_, "a-1", 0).Inverse();
    Placements moved = before_;
    for (SubmapPose& submap : moved[0].submaps) submap.T_map_submap = T * submap.T_map_submap;
    return LargestMove(moved, placements_);
  }

  World world_;
  Placer placer_;
  Placements placements_, before_;
};

TEST_F(Anchors, APosePlacesTheComponent) {
  AddAnchor(30, 0.02, 0.02, 0.1);
  Place();
  EXPECT_LT(Off(30), 1e-4);
  EXPECT_LT(Off(0), 0.5);
  EXPECT_LT(Bend(), 1e-3);
  const Pose gap = PoseOf(placements_, "a-1", 30).Inverse() * kSite * world_.Truth("a-1", 30);
  EXPECT_LT(RotationAngle(gap), 1e-4);
}

TEST_F(Anchors, APositionAloneDoesNotTurnIt) {
  AddAnchor(30, 0.02, 0.02, 0);
  Place();
  EXPECT_LT(Off(30), 1e-3);
  EXPECT_LT(Bend(), 2e-3);
  for (uint32_t k = 0; k < 100; k += 10) {
    EXPECT_LT(RotationAngle(PoseOf(before_, "a-1", k).Inverse() * PoseOf(placements_, "a-1", k)),
              1e-3);
  }
}

TEST_F(Anchors, TwoPositionsGiveAHeadingAndKeepTheVertical) {
  AddAnchor(0, 0.02, 0.02, 0);
  AddAnchor(25, 0.02, 0.02, 0);
  Place();
  EXPECT_LT(Off(0), 0.1);
  EXPECT_LT(Off(25), 0.1);
  const Pose turn = PoseOf(placements_, "a-1", 0) * PoseOf(before_, "a-1", 0).Inverse();
  const Eigen::Vector3d up = turn.rotation() * Eigen::Vector3d::UnitZ();
  EXPECT_GT(up.z(), std::cos(0.5 * std::numbers::pi / 180));
}

// Odometry a percent too long on flat ground: positions in plan must not tilt the map to fit.
TEST_F(Anchors, PositionsInPlanDoNotTiltTheMap) {
  for (uint32_t k = 0; k < 100; k += 10) {
    Anchor& anchor = AddAnchor(k, 0.5, 0, 0);
    const Eigen::Vector3d p = 0.99 * world_.Truth("a-1", k).translation();
    anchor.T_map_submap = kSite * Pose(p);
  }
  Place();
  for (uint32_t k = 0; k < 100; k += 5) {
    const Pose turn = PoseOf(placements_, "a-1", k) * PoseOf(before_, "a-1", k).Inverse();
    const Eigen::Vector3d up = turn.rotation() * Eigen::Vector3d::UnitZ();
    EXPECT_GT(up.z(), std::cos(1.5 * std::numbers::pi / 180));
    EXPECT_LT(std::abs(PoseOf(placements_, "a-1", k).translation().z() -
                       PoseOf(before_, "a-1", k).translation().z()),
              2.0);
  }
}

TEST_F(Anchors, AHeadingAloneTurnsItWhereItIs) {
  AddAnchor(0, 0, 0, 0.1);
  Place();
  EXPECT_LT((PoseOf(placements_, "a-1", 0).translation() - PoseOf(before_, "a-1", 0).translation())
                .norm(),
            1e-3);
  const Pose gap = PoseOf(placements_, "a-1", 0).Inverse() * kSite * world_.Truth("a-1", 0);
  EXPECT_LT(RotationAngle(gap), 1e-3);
  EXPECT_LT(Bend(), 2e-3);
}

TEST_F(Anchors, AWrongOneAmongFiveIsDiscarded) {
  for (uint32_t k = 5; k < 100; k += 20) AddAnchor(k, 0.05, 0.1, 0);
  world_.input.anchors[2].T_map_submap =
      Pose(Eigen::Vector3d(15, 20, 0)) * world_.input.anchors[2].T_map_submap;
  const Outcome outcome = placer_.Place(world_.input, placements_);
  placements_ = outcome.placements;
  for (uint32_t k = 5; k < 100; k += 20) {
    EXPECT_EQ(outcome.edge_status.anchors.at({SessionId("a-1"), k}), k != 45) << k;
    EXPECT_LT(Off(k), 0.2) << k;
  }
}

TEST_F(Anchors, LessThanFourAreBelieved) {
  AddAnchor(0, 0.02, 0.02, 0.1);
  AddAnchor(25, 0.02, 0.02, 0.1);
  world_.input.anchors[1].T_map_submap =
      Pose(Eigen::Vector3d(1, 0, 0)) * world_.input.anchors[1].T_map_submap;
  const Outcome outcome = placer_.Place(world_.input, placements_);
  for (const auto& [id, kept] : outcome.edge_status.anchors) EXPECT_TRUE(kept);
  placements_ = outcome.placements;
  EXPECT_LT(Off(0), 0.8);
  EXPECT_GT(Off(25), 0.2);
}

TEST_F(Anchors, StopDrift) {
  World open(2);
  open.AddRobot("a-1", 100, 200, 160);
  const Placements odometry = Placer().Place(open.input, {}).placements;
  for (uint32_t k = 0; k < 100; k += 9) {
    Anchor anchor;
    anchor.submap = {SessionId("a-1"), k};
    anchor.T_map_submap = kSite * open.Truth("a-1", k);
    anchor.sigma_xy_m = anchor.sigma_z_m = 0.1;
    open.input.anchors.push_back(anchor);
  }
  Placer placer;
  placements_ = placer.Place(open.input, odometry).placements;
  EXPECT_GT(Rmse(open, odometry, "a-1"), 1.0);
  for (const SubmapPose& submap : placements_[0].submaps) {
    const Eigen::Vector3d truth = kSite * open.Truth("a-1", submap.index).translation();
    EXPECT_LT((submap.T_map_submap.translation() - truth).norm(), 0.2) << submap.index;
  }
}

TEST_F(Anchors, TakenBackLeaveNothingBehind) {
  AddAnchor(30, 0.02, 0.02, 0.1);
  AddAnchor(60, 0.02, 0.02, 0.1);
  world_.input.anchors[1].T_map_submap =
      Pose(Eigen::Vector3d(3, 0, 0)) * world_.input.anchors[1].T_map_submap;
  Place();
  EXPECT_GT(LargestMove(before_, placements_), 100);
  world_.input.anchors.pop_back();
  Place();
  EXPECT_LT(Off(30), 1e-3);
  EXPECT_LT(Bend(), 1e-3);
  world_.input.anchors.clear();
  Place();
  EXPECT_LT(LargestMove(before_, placements_), 1e-3);
}

TEST_F(Anchors, HoldSessionsThatJoin) {
  AddAnchor(30, 0.02, 0.02, 0.1);
  Place();
  const Placements anchored = placements_;
  world_.AddRobot("b-1", 60, 50, 40, 10);
  Place();
  world_.AddMatch("a-1", "b-1", {{20, 10}, {30, 20}, {40, 30}});
  Place();
  EXPECT_LT(LargestMove({anchored[0]}, placements_), 0.1);
  const Pose b = kSite * world_.Truth("b-1", 20);
  EXPECT_LT((PoseOf(placements_, "b-1", 20).translation() - b.translation()).norm(), 0.5);
}

TEST_F(Anchors, OfAnotherSessionMoveTheReference) {
  world_.AddRobot("b-1", 60, 50, 40, 10);
  Anchor& anchor = AddAnchor(20, 0.02, 0.02, 0.1);
  anchor.submap.session = SessionId("b-1");
  anchor.T_map_submap = kSite * world_.Truth("b-1", 20);
  Place();
  EXPECT_EQ(LargestMove({before_[0]}, placements_), 0);
  world_.AddMatch("a-1", "b-1", {{20, 10}, {30, 20}, {40, 30}});
  Place();
  EXPECT_EQ(placements_[1].reference, SessionId("a-1"));
  EXPECT_LT(Off(30), 0.5);
}

TEST_F(Anchors, HoldTheFrameAfterTheirSubmapHasLeft) {
  AddAnchor(30, 0.02, 0.02, 0.1);
  Place();
  const Placements anchored = placements_;
  world_.Retire("a-1", 28, 32);
  Place();
  EXPECT_EQ(LargestMove(anchored, placements_), 0);
  world_.AddLoop("a-1", 20, 70);
  Place();
  EXPECT_LT(LargestMove(anchored, placements_), 0.1);
}

TEST_F(Anchors, AreFoundAgainAfterARestart) {
  AddAnchor(30, 0.02, 0.02, 0.1);
  AddAnchor(60, 0.5, 0.5, 0);
  const Placements anchored = Place();
  EXPECT_LT(LargestMove(anchored, Placer().Place(world_.input, anchored).placements), 1e-3);
}

}  // namespace
}  // namespace isthmus::placement
