// Loop closures and retired submaps as the server keeps them: stored, shown, gone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/server/threads/placed_map.h"

namespace isthmus::server {
namespace {

using ::testing::HasSubstr;

constexpr uint32_t kSubmaps = 8;

// With 0.3 m of drift by the end.
std::shared_ptr<Submap> MakeSubmap(uint32_t index) {
  auto submap = std::make_shared<Submap>();
  submap->id = {kSession, index};
  submap->robot = RobotId("alice");
  const double drift = 0.3 * index / (kSubmaps - 1);
  submap->T_odom_submap = Pose(Eigen::Vector3d(drift, drift, 0)) * SquareOf(index);
  submap->first_sequence = 2 * index + 1;
  submap->last_sequence = 2 * index + 2;
  submap->keyframes = {{2 * index + 1, 1'000'000'000 * int64_t{index}, Pose()}};
  submap->points = {{1, 2, 3, 0, 0}};
  return submap;
}

LoopClosure Closure(uint32_t a, uint32_t b) {
  LoopClosure loop;
  loop.session = kSession;
  loop.submap_a = a;
  loop.submap_b = b;
  loop.T_a_b = SquareOf(a).Inverse() * SquareOf(b);
  loop.confidence = 0.99;
  loop.source = GuessSource::kOdometry;
  loop.edges = {{a, b, loop.T_a_b, 1e4 * Matrix6d::Identity()}};
  return loop;
}

class PipelineGraph : public PlacedMapTest {
 protected:
  void SetUp() override {
    ASSERT_NO_FATAL_FAILURE(Begin({.sessions = {SessionOf("alice")}}));
    for (uint32_t i = 0; i < kSubmaps; ++i) {
      FinishedSubmap finished;
      finished.submap = MakeSubmap(i);
      for (uint64_t k : {2 * i + 1, 2 * i + 2}) {
        finished.trajectory.push_back(
            {k, int64_t(k) * 500'000'000, finished.submap->T_odom_submap, i});
      }
      ASSERT_TRUE(map_.AddSubmap(kSession, finished).ok());
    }
  }

  std::optional<Pose> PoseOf(uint32_t index) {
    map_.WaitUntilPlaced();
    const MapWriter::View view = map_.view();
    for (const SubmapPose& pose : view->revision->placements.at(0).submaps) {
      if (pose.index == index) return pose.T_map_submap;
    }
    return std::nullopt;
  }
  double ErrorOf(uint32_t index) {
    return (PoseOf(index)->translation() - SquareOf(index).translation()).norm();
  }
};

TEST_F(PipelineGraph, ALoopClosureStraightensTheMapAndIsTakenBack) {
  const double open = ErrorOf(7), half_way = ErrorOf(4);
  ASSERT_GT(open, 0.4);
  ASSERT_TRUE(map_.AddLoops({Closure(0, 7)}).ok());
  EXPECT_LT(ErrorOf(7), 0.1);
  EXPECT_LT(ErrorOf(4), half_way) << "what lies between takes its share";
  EXPECT_EQ(ErrorOf(0), 0);
  EXPECT_THAT(map_.view()->revision->cause, HasSubstr("loop 1"));
  EXPECT_THAT(map_.view()->revision->loops, testing::ElementsAre(1u));

  LoopClosure rejected = store_->ListLoops()->at(0);
  rejected.rejected = true;
  ASSERT_TRUE(map_.PutDecisions({.loops = {rejected}}).ok());
  EXPECT_NEAR(ErrorOf(7), open, 1e-3);
}

TEST_F(PipelineGraph, LoopClosuresHoldOverARestart) {
  ASSERT_TRUE(map_.AddLoops({Closure(0, 7)}).ok());
  const Pose before = *PoseOf(7);
  const int64_t revision = map_.view()->revision->revision;
  placement_.reset();
  SubmapCache submaps(store_.get(), size_t{1} << 30, nullptr);
  Activity activity;
  MapWriter again(store_.get(), &submaps, &activity, &Clock::System());
  ASSERT_TRUE(again.Load().ok());
  PlacementThread placement(&again, &activity, store_.get(), &Clock::System(), {});
  again.WaitUntilPlaced();
  EXPECT_EQ(again.view()->revision->revision, revision) << "nothing has moved";
  EXPECT_EQ(again.view()->revision->placements.at(0).submaps.back().T_map_submap.translation(),
            before.translation());
  EXPECT_EQ(again.view()->loops.size(), 1u);
}

TEST_F(PipelineGraph, RetiredSubmapsLeaveWithTheirScansAndTheRestStays) {
  ASSERT_TRUE(map_.AddLoops({Closure(0, 7), Closure(1, 7)}).ok());
  const Pose last = *PoseOf(7), sixth = *PoseOf(5);
  ASSERT_TRUE(map_.RetireSubmaps({{kSession, 1}, {kSession, 2}}).ok());
  EXPECT_FALSE(PoseOf(1));
  EXPECT_FALSE(PoseOf(2));
  EXPECT_LT((PoseOf(7)->translation() - last.translation()).norm(), 0.05);
  EXPECT_LT((PoseOf(5)->translation() - sixth.translation()).norm(), 0.05);
  EXPECT_EQ(map_.view()->loops.size(), 1u) << "that of a retired submap went with it";
  EXPECT_EQ(store_->ListLoops()->size(), 1u);
  EXPECT_EQ(store_->ListSubmaps(kSession)->size(), kSubmaps - 2);
  EXPECT_EQ(store_->GetTrajectory(kSession)->size(), 2 * (kSubmaps - 2));
  EXPECT_EQ(submaps_.Get({kSession, 1}), nullptr);
  EXPECT_EQ(map_.view()->Find(kSession)->next_index(), kSubmaps);
  EXPECT_EQ(map_.view()->PlacedSubmaps().size(), kSubmaps - 2);
}

// Undoing a revision would otherwise reject a loop closure that has nothing to do with it.
TEST_F(PipelineGraph, NumbersOfLoopClosuresAreNotGivenAgain) {
  ASSERT_TRUE(map_.AddLoops({Closure(0, 7)}).ok());
  map_.WaitUntilPlaced();
  ASSERT_TRUE(map_.RetireSubmaps({{kSession, 0}}).ok());
  ASSERT_TRUE(map_.view()->loops.empty());
  ASSERT_TRUE(map_.AddLoops({Closure(1, 6)}).ok());
  EXPECT_EQ(map_.view()->loops.begin().key(), 2u);
  map_.WaitUntilPlaced();
  ASSERT_TRUE(map_.RetireSubmaps({{kSession, 1}}).ok());
  placement_.reset();
  SubmapCache submaps(store_.get(), size_t{1} << 30, nullptr);
  Activity activity;
  MapWriter again(store_.get(), &submaps, &activity, &Clock::System());
  ASSERT_TRUE(again.Load().ok());
  ASSERT_TRUE(again.AddLoops({Closure(2, 5)}).ok());
  EXPECT_EQ(again.view()->loops.begin().key(), 3u);
}

}  // namespace
}  // namespace isthmus::server
