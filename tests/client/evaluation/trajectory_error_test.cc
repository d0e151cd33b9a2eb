#include "client/evaluation/trajectory_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace isthmus::evaluation {
namespace {

using ::testing::HasSubstr;

constexpr int64_t kStep = 100'000'000;

// A bent path of `count` poses, starting at `from`.
Trajectory Path(int count, double from = 0) {
  Trajectory path;
  for (int i = 0; i < count; ++i) {
    const double t = from + 0.2 * i;
    path.push_back(
        {i * kStep, Pose::FromXyzRpy(5 * std::cos(t), 8 * std::sin(t), 0.3 * t, 0.02, 0.01, t)});
  }
  return path;
}

Trajectory Moved(const Pose& T, Trajectory path) {
  for (StampedPose& entry : path) entry.pose = T * entry.pose;
  return path;
}

const Pose kAnyFrame = Pose::FromXyzRpy(3, -4, 1, 0.1, -0.2, 2.5);

TEST(CompareTrajectories, AnotherFrameIsNoErrorAfterAlignment) {
  const Trajectory truth = Path(50);
  const TrajectoryPair pair{"a", truth, Moved(kAnyFrame, truth)};
  for (const Alignment alignment : {Alignment::kRigid, Alignment::kFirstPose}) {
    const auto errors = CompareTrajectories({pair}, alignment);
    ASSERT_TRUE(errors.ok()) << errors.status();
    EXPECT_EQ(errors->all.count, 50u);
    EXPECT_LT(errors->all.max_m, 1e-9);
    EXPECT_LT(errors->all.rotation_deg.rmse, 1e-6);
    EXPECT_LT(Log(errors->T_truth_estimate * kAnyFrame).norm(), 1e-9);
  }
  const auto unaligned = CompareTrajectories({pair}, Alignment::kNone);
  EXPECT_GT(unaligned->all.rmse_m, 1);
}

TEST(CompareTrajectories, StatisticsOfKnownErrors) {
  Trajectory truth = Path(4), estimate = truth;
  const double errors_m[] = {0, 1, 2, 5};
  for (int i = 0; i < 4; ++i) {
    estimate[i].pose = Pose(Eigen::Vector3d(0, 0, errors_m[i])) * estimate[i].pose;
  }
  estimate[2].pose = estimate[2].pose * Pose::FromXyzRpy(0, 0, 0, 0, 0, 0.1);
  const auto errors = CompareTrajectories({{"a", truth, estimate}}, Alignment::kNone);
  ASSERT_TRUE(errors.ok());
  EXPECT_NEAR(errors->all.rmse_m, std::sqrt(30.0 / 4), 1e-9);
  EXPECT_NEAR(errors->all.mean_m, 2, 1e-9);
  EXPECT_NEAR(errors->all.median_m, 1.5, 1e-9);
  EXPECT_NEAR(errors->all.max_m, 5, 1e-9);
  EXPECT_NEAR(errors->all.rotation_deg.rmse, 0.05 * 180 / M_PI, 1e-9);
}

TEST(CompareTrajectories, NoScaleIsFitted) {
  const Trajectory truth = Path(50);
  Trajectory larger;
  for (const StampedPose& entry : truth) {
    larger.push_back({entry.stamp_ns, Pose(entry.pose.rotation(), 1.1 * entry.pose.translation())});
  }
  EXPECT_GT(CompareTrajectories({{"a", truth, larger}})->all.rmse_m, 0.3);
}

TEST(CompareTrajectories, MirroredPathsDoNotAlign) {
  const Trajectory truth = Path(50);
  Trajectory mirrored;
  for (const StampedPose& entry : truth) {
    const Eigen::Vector3d p = entry.pose.translation();
    mirrored.push_back({entry.stamp_ns, Pose(Eigen::Vector3d(p.x() + 0.2 * p.y(), -p.y(), p.z()))});
  }
  const auto errors = CompareTrajectories({{"a", truth, mirrored}});
  EXPECT_NEAR(errors->T_truth_estimate.RotationMatrix().determinant(), 1, 1e-9);
  EXPECT_GT(errors->all.rmse_m, 0.1);
}

TEST(CompareTrajectories, RobotsOfAMergedMapShareOneAlignment) {
  const Trajectory a = Path(40), b = Path(40, 3);
  const Pose misplaced = kAnyFrame * Pose(Eigen::Vector3d(0, 0, 2));
  const TrajectoryPair right{"a", a, Moved(kAnyFrame, a)}, wrong{"b", b, Moved(misplaced, b)};
  // Each by itself is perfect.
  EXPECT_LT(CompareTrajectories({right})->all.rmse_m, 1e-9);
  EXPECT_LT(CompareTrajectories({wrong})->all.rmse_m, 1e-9);
  // Together, b lies 2 m beside where it should; the first pose of a fixes the frame.
  const auto first = CompareTrajectories({right, wrong}, Alignment::kFirstPose);
  ASSERT_TRUE(first.ok());
  EXPECT_LT(first->robots[0].rmse_m, 1e-9);
  EXPECT_NEAR(first->robots[1].rmse_m, 2, 1e-9);
  EXPECT_NEAR(first->all.rmse_m, std::sqrt(2), 1e-9);
  const auto rigid = CompareTrajectories({right, wrong});
  EXPECT_GT(rigid->all.rmse_m, 0.3);
  EXPECT_LT(rigid->all.rmse_m, first->all.rmse_m);
}

TEST(CompareTrajectories, AssociatesTheNearestStampInAnyOrder) {
  Trajectory truth = Path(20), estimate = truth;
  for (StampedPose& entry : estimate) entry.stamp_ns += 15'000'000;
  estimate[4].stamp_ns += 30'000'000;  // Too far from any.
  std::swap(estimate[2], estimate[9]);
  const auto errors = CompareTrajectories({{"a", truth, estimate}}, Alignment::kNone);
  ASSERT_TRUE(errors.ok());
  EXPECT_EQ(errors->all.count, 19u);
  EXPECT_LT(errors->all.max_m, 1e-12);
}

TEST(CompareTrajectories, SaysWhatToDoWithoutCommonStamps) {
  const Trajectory truth = Path(20);
  Trajectory late = truth;
  for (StampedPose& entry : late) entry.stamp_ns += 3'600'000'000'000;
  for (const Trajectory& estimate : {late, Trajectory{}}) {
    const auto errors = CompareTrajectories({{"bob", truth, estimate}});
    EXPECT_EQ(errors.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(errors.status().message()), HasSubstr("bob"));
    EXPECT_THAT(std::string(errors.status().message()), HasSubstr("check that"));
  }
  EXPECT_EQ(CompareTrajectories({}).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(CompareTrajectories, TwoPosesAreTooFewForARigidAlignment) {
  const Trajectory truth = Path(2);
  EXPECT_EQ(CompareTrajectories({{"a", truth, truth}}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(CompareTrajectories({{"a", truth, truth}}, Alignment::kFirstPose).ok());
}

}  // namespace
}  // namespace isthmus::evaluation
