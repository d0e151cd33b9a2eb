// The shapes by which sessions are matched, as the map changes and over a restart.
#include "server/threads/session_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <set>
#include <vector>

#include "tests/server/threads/placed_map.h"

namespace isthmus::server {
namespace {

constexpr uint32_t kShapeSubmaps = 8;

// With 2 m of drift by the end.
std::shared_ptr<Submap> MakeBentSubmap(uint32_t index) {
  auto submap = std::make_shared<Submap>();
  submap->id = {kSession, index};
  submap->robot = RobotId("alice");
  const double drift = 2.0 * index / (kShapeSubmaps - 1);
  submap->T_odom_submap = Pose(Eigen::Vector3d(drift, 0, 0)) * SquareOf(index);
  submap->first_sequence = submap->last_sequence = index + 1;
  submap->keyframes = {{index + 1, 1'000'000'000 * int64_t{index}, Pose()}};
  submap->points = {{1, 2, 3, 0, 0}};
  return submap;
}

LoopClosure ShapeLoop(uint32_t a, uint32_t b) {
  LoopClosure loop;
  loop.session = kSession;
  loop.submap_a = a;
  loop.submap_b = b;
  loop.T_a_b = SquareOf(a).Inverse() * SquareOf(b);
  loop.edges = {{a, b, loop.T_a_b, 1e4 * Matrix6d::Identity()}};
  return loop;
}

class SessionShapesTest : public PlacedMapTest {
 protected:
  void SetUp() override {
    storage::WriteBatch batch;
    batch.sessions = {SessionOf("alice"), SessionOf("bob")};
    for (uint32_t i = 0; i < kShapeSubmaps; ++i) batch.submaps.push_back(MakeBentSubmap(i));
    ASSERT_NO_FATAL_FAILURE(Begin(batch));
    map_.WaitUntilPlaced();
  }

  const SubmapReader outlines_ = [this](const SubmapId& id) { return submaps_.Outline(id); };

  // Does all that is outstanding; returns the number of sessions.
  size_t Look(SessionShapes* shapes) {
    const MapWriter::View view = map_.view();
    const std::set<SessionId> outdated = shapes->FindOutdated(*view);
    for (const SessionId& id : outdated) shapes->Update(*view, id);
    return outdated.size();
  }
  SessionShapes::Shaped ShapeOf(SessionShapes* shapes) {
    const MapWriter::View view = map_.view();
    return shapes->Of(*view, *view->Find(kSession));
  }
  double ErrorOfLast(SessionShapes* shapes) {
    const Pose& last = ShapeOf(shapes).submaps.back()->T_odom_submap;
    return (last.translation() - SquareOf(kShapeSubmaps - 1).translation()).norm();
  }
};

TEST_F(SessionShapesTest, WithoutLoopsThereIsNone) {
  SessionShapes shapes(outlines_);
  EXPECT_EQ(Look(&shapes), 0u);
  EXPECT_EQ(ShapeOf(&shapes).shape, nullptr);
  EXPECT_EQ(ShapeOf(&shapes).submaps[3], submaps_.Outline({kSession, 3}));
  EXPECT_EQ(shapes.versions()[kSession], 0u);
}

TEST_F(SessionShapesTest, ALoopMovesItOnceAndIsTakenBack) {
  SessionShapes shapes(outlines_);
  Look(&shapes);
  ASSERT_TRUE(map_.AddLoops({ShapeLoop(0, 7)}).ok());
  EXPECT_EQ(Look(&shapes), 1u);
  EXPECT_EQ(Look(&shapes), 0u) << "nothing is new";
  EXPECT_EQ(shapes.versions()[kSession], 1u);
  ASSERT_NE(ShapeOf(&shapes).shape, nullptr);
  EXPECT_LT(ErrorOfLast(&shapes), 0.3);
  EXPECT_EQ(ShapeOf(&shapes).submaps[3], ShapeOf(&shapes).submaps[3]) << "the very same";

  // Another that says the same moves nothing.
  ASSERT_TRUE(map_.AddLoops({ShapeLoop(0, 6)}).ok());
  EXPECT_EQ(Look(&shapes), 1u);
  EXPECT_EQ(shapes.versions()[kSession], 1u);

  std::vector<LoopClosure> rejected = *store_->ListLoops();
  for (LoopClosure& loop : rejected) loop.rejected = true;
  ASSERT_TRUE(map_.PutDecisions({.loops = rejected}).ok());
  EXPECT_EQ(Look(&shapes), 1u);
  EXPECT_EQ(shapes.versions()[kSession], 2u);
  EXPECT_EQ(ShapeOf(&shapes).submaps[3], submaps_.Outline({kSession, 3}));
}

TEST_F(SessionShapesTest, ARestartGivesTheSameShape) {
  SessionShapes shapes(outlines_);
  Look(&shapes);
  ASSERT_TRUE(map_.AddLoops({ShapeLoop(0, 7)}).ok());
  Look(&shapes);
  SessionShapes again(outlines_);
  EXPECT_EQ(Look(&again), 0u) << "it is made when somebody asks";
  const auto before = ShapeOf(&shapes).submaps, after = ShapeOf(&again).submaps;
  EXPECT_EQ(again.versions()[kSession], 0u);
  ASSERT_EQ(before.size(), after.size());
  for (size_t k = 0; k < before.size(); ++k) {
    EXPECT_LT(
        (before[k]->T_odom_submap.translation() - after[k]->T_odom_submap.translation()).norm(),
        1e-6);
  }
}

TEST_F(SessionShapesTest, AfterARestartLoopsThatComeBeforeAnyoneAskedCountAsAMove) {
  ASSERT_TRUE(map_.AddLoops({ShapeLoop(0, 6)}).ok());
  SessionShapes shapes(outlines_);
  Look(&shapes);
  ASSERT_TRUE(map_.AddLoops({ShapeLoop(0, 7)}).ok());
  EXPECT_EQ(Look(&shapes), 0u);
  EXPECT_EQ(shapes.versions()[kSession], 1u);
  EXPECT_LT(ErrorOfLast(&shapes), 0.3);
}

TEST_F(SessionShapesTest, OneThatIsLeftOutIsAsItsOdometryHasIt) {
  SessionShapes shapes(outlines_);
  Look(&shapes);
  ASSERT_TRUE(map_.AddLoops({ShapeLoop(0, 7)}).ok());
  Look(&shapes);
  shapes.LeaveOut(kSession);
  EXPECT_EQ(shapes.versions()[kSession], 2u);
  EXPECT_EQ(ShapeOf(&shapes).shape, nullptr);
  ASSERT_TRUE(map_.AddLoops({ShapeLoop(0, 6)}).ok());
  EXPECT_EQ(Look(&shapes), 0u);
}

TEST_F(SessionShapesTest, ADeletedSessionIsForgotten) {
  SessionShapes shapes(outlines_);
  Look(&shapes);
  ASSERT_TRUE(map_.AddLoops({ShapeLoop(0, 7)}).ok());
  Look(&shapes);
  ASSERT_TRUE(map_.RemoveSession(kSession).ok());
  EXPECT_EQ(Look(&shapes), 0u);
  EXPECT_EQ(shapes.versions()[kSession], 0u);
}

}  // namespace
}  // namespace isthmus::server
