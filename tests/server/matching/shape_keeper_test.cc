#include "server/matching/prepared/shape_keeper.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "server/matching/prepared/limits.h"

namespace isthmus::matching {
namespace {

constexpr uint32_t kLap = 8;

// Round and round a square of 20 m, two submaps a side.
Pose TruthOf(uint32_t index) {
  const Pose side = Pose::FromXyzRpy(10, 0, 0, 0, 0, 0);
  const Pose corner = Pose::FromXyzRpy(10, 0, 0, 0, 0, M_PI / 2);
  Pose pose;
  for (uint32_t i = 0; i < index; ++i) pose = pose * (i % 2 == 0 ? side : corner);
  return pose;
}

// Each step is off by so much: 0.1 m of 10.
SubmapList Odometry(uint32_t count, double off_m = 0.1, const Pose& T_odom_first = Pose()) {
  SubmapList submaps;
  Pose pose = T_odom_first;
  for (uint32_t i = 0; i < count; ++i) {
    auto submap = std::make_shared<Submap>();
    submap->id = {SessionId("alice-1"), i};
    submap->T_odom_submap = pose;
    submap->keyframes = {{i + 1, 0, Pose()}};
    submaps.push_back(std::move(submap));
    pose = pose * (TruthOf(i).Inverse() * TruthOf(i + 1)) *
           Pose::FromXyzRpy(off_m, 0.5 * off_m, 0, 0, 0, 0.05 * off_m);
  }
  return submaps;
}

LoopClosure Closure(uint64_t id, uint32_t a, uint32_t b, const Pose& wrong_by = Pose()) {
  LoopClosure loop;
  loop.id = id;
  loop.session = SessionId("alice-1");
  loop.submap_a = a;
  loop.submap_b = b;
  loop.T_a_b = TruthOf(a).Inverse() * TruthOf(b) * wrong_by;
  loop.edges = {{a, b, loop.T_a_b, 1e4 * Matrix6d::Identity()}};
  return loop;
}

// The largest error of a position, relative to the first submap.
double WorstError(const SubmapList& submaps) {
  double worst = 0;
  for (const auto& submap : submaps) {
    const Pose T = submaps[0]->T_odom_submap.Inverse() * submap->T_odom_submap;
    const Pose truth = TruthOf(submaps[0]->id.index).Inverse() * TruthOf(submap->id.index);
    worst = std::max(worst, (T.translation() - truth.translation()).norm());
  }
  return worst;
}

SubmapList Some(const SubmapList& submaps, size_t first, size_t end) {
  return {submaps.begin() + static_cast<std::ptrdiff_t>(first),
          submaps.begin() + static_cast<std::ptrdiff_t>(end)};
}

TEST(ShapeKeeper, WithoutLoopsItIsTheOdometryItself) {
  const SubmapList drive = Odometry(6);
  ShapeKeeper keeper;
  EXPECT_FALSE(keeper.Update(Some(drive, 0, 3), {}, false, nullptr));
  EXPECT_FALSE(keeper.Update(drive, {}, true, nullptr));
  EXPECT_EQ(keeper.submaps(), drive);  // The very same.
  EXPECT_EQ(keeper.shape()->edges.size(), drive.size() - 1);
}

TEST(ShapeKeeper, LoopsStraightenTheMap) {
  const Pose T_odom_first = Pose::FromXyzRpy(30, -5, 1, 0, 0, 2);
  const SubmapList drive = Odometry(kLap + 1, 0.1, T_odom_first);
  ASSERT_GT(WorstError(drive), 0.5);
  ShapeKeeper keeper;
  keeper.Update(drive, {}, false, nullptr);
  EXPECT_TRUE(keeper.Update(drive, {Closure(1, 0, kLap)}, false, nullptr));
  EXPECT_LT(WorstError(keeper.submaps()), 0.5 * WorstError(drive));
  // Unchanged: the frame, the first submap, the order, and the odometry.
  EXPECT_EQ(keeper.submaps()[0], drive[0]);
  EXPECT_EQ(keeper.submaps()[5]->id, drive[5]->id);
  EXPECT_EQ(keeper.submaps()[5]->keyframes.size(), 1u);
  EXPECT_TRUE(keeper.shape()->odometry[5].Matrix() == drive[5]->T_odom_submap.Matrix());
  EXPECT_EQ(keeper.shape()->edges.size(), drive.size());
}

TEST(ShapeKeeper, ASessionKnownFromBeforeHasItsShapeAtOnce) {
  const SubmapList drive = Odometry(kLap + 1);
  ShapeKeeper keeper;
  EXPECT_FALSE(keeper.Update(drive, {Closure(1, 0, kLap)}, true, nullptr));  // Nothing was there.
  EXPECT_LT(WorstError(keeper.submaps()), 0.5 * WorstError(drive));
}

TEST(ShapeKeeper, WhatMovesItLittleChangesNothing) {
  const SubmapList drive = Odometry(kLap + 3, 0.005);
  ShapeKeeper keeper;
  const SubmapList before = Some(drive, 0, kLap + 1);
  keeper.Update(before, {}, false, nullptr);
  EXPECT_FALSE(keeper.Update(before, {Closure(1, 0, kLap)}, false, nullptr));
  EXPECT_EQ(keeper.submaps(), before);
  // New ones lie as the shape has them, within what went unnoticed.
  EXPECT_FALSE(keeper.Update(drive, {Closure(1, 0, kLap)}, false, nullptr));
  EXPECT_EQ(Some(keeper.submaps(), 0, before.size()), before);
  EXPECT_LT(WorstError(keeper.submaps()), kReshapedM);
}

TEST(ShapeKeeper, IsNotGivenAnewWithEverySubmap) {
  const SubmapList drive = Odometry(3 * kLap);
  std::vector<LoopClosure> loops;
  ShapeKeeper keeper;
  int moved = 0;
  for (uint32_t n = 1; n <= drive.size(); ++n) {
    if (n > kLap) loops.push_back(Closure(n, n - 1 - kLap, n - 1));
    moved += keeper.Update(Some(drive, 0, n), loops, n == drive.size(), nullptr);
  }
  EXPECT_GE(moved, 1);
  EXPECT_LE(moved, 5);
  EXPECT_LT(WorstError(keeper.submaps()), 0.25 * WorstError(drive));
}

TEST(ShapeKeeper, ASessionThatGoesOnWaitsUntilItHasGrown) {
  const SubmapList drive = Odometry(kLap + 2);
  const LoopClosure poor = Closure(1, 0, kLap, Pose(Eigen::Vector3d(0.6, 0, 0)));
  const std::vector<LoopClosure> better = {poor, Closure(2, 0, kLap + 1), Closure(3, 1, kLap + 1),
                                           Closure(4, 2, kLap + 1)};
  ShapeKeeper going_on, finished;
  for (ShapeKeeper* keeper : {&going_on, &finished}) {
    keeper->Update(drive, {}, false, nullptr);
    ASSERT_TRUE(keeper->Update(drive, {poor}, false, nullptr));
  }
  EXPECT_FALSE(going_on.Update(drive, better, false, nullptr));
  EXPECT_TRUE(finished.Update(drive, better, true, nullptr));
}

TEST(ShapeKeeper, AWrongLoopIsOutvoted) {
  const SubmapList drive = Odometry(2 * kLap);
  std::vector<LoopClosure> loops;
  for (uint32_t i = 0; i < kLap; ++i) loops.push_back(Closure(i + 1, i, i + kLap));
  loops.push_back(Closure(20, 3, 9));
  loops.back().edges[0].T_a_b = Pose();  // Taken for the same place.
  ShapeKeeper keeper;
  keeper.Update(drive, loops, true, nullptr);
  EXPECT_LT(WorstError(keeper.submaps()), 0.3);
  EXPECT_EQ(keeper.shape()->edges.size(), drive.size() - 1 + kLap);
}

TEST(ShapeKeeper, ALoopTakenBackLeavesNothing) {
  const SubmapList drive = Odometry(kLap + 1);
  LoopClosure loop = Closure(1, 0, kLap);
  ShapeKeeper keeper;
  keeper.Update(drive, {loop}, false, nullptr);
  ASSERT_NE(keeper.submaps(), drive);
  loop.rejected = true;
  EXPECT_TRUE(keeper.Update(drive, {loop}, false, nullptr));
  EXPECT_EQ(keeper.submaps(), drive);
}

// With them go the loops that they were part of.
TEST(ShapeKeeper, RetiredSubmapsLeaveTheRestWhereItLies) {
  const SubmapList drive = Odometry(kLap + 4);
  ShapeKeeper keeper;
  const SubmapList all = Some(drive, 0, kLap + 2);
  keeper.Update(all, {Closure(1, 0, kLap), Closure(2, 1, kLap + 1)}, false, nullptr);
  const SubmapList shaped = keeper.submaps();
  SubmapList left = Some(drive, 4, kLap);
  left.push_back(drive[kLap + 1]);
  EXPECT_FALSE(keeper.Update(left, {}, true, nullptr));
  for (size_t k = 0; k < 4; ++k) EXPECT_EQ(keeper.submaps()[k], shaped[k + 4]);
  EXPECT_EQ(keeper.submaps()[4], shaped[kLap + 1]);
  left.push_back(drive[kLap + 2]);
  EXPECT_FALSE(keeper.Update(left, {}, true, nullptr));
  EXPECT_EQ(keeper.submaps()[4], shaped[kLap + 1]);
  EXPECT_LT(WorstError(keeper.submaps()), WorstError(left));
}

TEST(ShapeKeeper, AfterARestartGapsAreAsPublished) {
  const SubmapList drive = Odometry(2 * kLap + 2);
  SubmapList left = Some(drive, 0, 2);
  for (const auto& submap : Some(drive, kLap + 3, drive.size())) left.push_back(submap);
  Placement published;
  for (const auto& submap : left) {
    published.submaps.push_back(
        {submap->id.index, Pose(Eigen::Vector3d(7, 8, 9)) * TruthOf(submap->id.index)});
  }
  const std::vector<LoopClosure> loops = {Closure(1, 0, 2 * kLap), Closure(2, 1, 2 * kLap + 1)};
  ShapeKeeper with, without;
  with.Update(left, loops, true, &published);
  without.Update(left, loops, true, nullptr);
  EXPECT_LT(WorstError(with.submaps()), 0.25 * WorstError(left));
  EXPECT_LT(WorstError(with.submaps()), WorstError(without.submaps()));
}

TEST(ShapeKeeper, TheSameCallsGiveTheSame) {
  const SubmapList drive = Odometry(2 * kLap);
  ShapeKeeper first, second;
  for (ShapeKeeper* keeper : {&first, &second}) {
    keeper->Update(Some(drive, 0, kLap + 1), {Closure(1, 0, kLap)}, false, nullptr);
    keeper->Update(drive, {Closure(1, 0, kLap), Closure(2, 3, kLap + 3)}, true, nullptr);
  }
  for (size_t k = 0; k < drive.size(); ++k) {
    EXPECT_TRUE(first.submaps()[k]->T_odom_submap.Matrix() ==
                second.submaps()[k]->T_odom_submap.Matrix());
  }
}

TEST(ShapeKeeper, StepsKnowTheOdometrysOwnDrift) {
  const SubmapList drive = Odometry(3);
  auto slid = std::make_shared<Submap>(*drive[1]);
  slid->drift_covariance(0, 0) = 4;
  SubmapList submaps = {drive[0], slid, drive[2]};
  const auto plain = OdometrySteps(drive), own = OdometrySteps(submaps);
  EXPECT_GT(plain[0].information(0, 0), 50);
  EXPECT_LT(own[0].information(0, 0), 0.3);
  EXPECT_TRUE(own[1].information == plain[1].information);
  // It is since the submap before, not across a gap.
  submaps = {drive[0], drive[2]};
  auto later = std::make_shared<Submap>(*drive[2]);
  later->drift_covariance(0, 0) = 4;
  EXPECT_TRUE(OdometrySteps({drive[0], later})[0].information ==
              OdometrySteps(submaps)[0].information);
}

}  // namespace
}  // namespace isthmus::matching
