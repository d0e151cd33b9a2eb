#include "client/evaluation/relative_error.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "client/evaluation/evaluation.h"

namespace isthmus::evaluation {
namespace {

// A straight drive of `count` poses, `step_m` apart; the estimate is longer by that factor.
std::vector<PosePair> Straight(int count, double step_m, double factor) {
  std::vector<PosePair> pairs;
  for (int i = 0; i < count; ++i) {
    pairs.push_back({i * int64_t{100'000'000}, Pose(Eigen::Vector3d(step_m * i, 0, 0)),
                     Pose(Eigen::Vector3d(factor * step_m * i, 0, 0))});
  }
  return pairs;
}

// A bent drive with a drifting, noisy estimate in another frame.
std::vector<PosePair> Drifting(int count, double step_m) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 1);
  std::vector<PosePair> pairs;
  Pose truth = Pose::FromXyzRpy(4, 5, 6, 0.1, 0.2, 0.3), estimate;
  for (int i = 0; i < count; ++i) {
    pairs.push_back({i * int64_t{100'000'000}, truth, estimate});
    const double turn = 0.05 * std::sin(0.01 * i);
    truth = truth * Pose::FromXyzRpy(step_m, 0, 0, 0, 0, turn);
    estimate = estimate * Pose::FromXyzRpy(step_m * (1.01 + 0.02 * noise(random)), 0.01, 0,
                                           0.001 * noise(random), 0, turn + 1e-4);
  }
  return pairs;
}

// Straight from the definition, with matrices and every pair tried.
struct BruteForce {
  explicit BruteForce(const std::vector<PosePair>& pairs) : pairs_(pairs) {}

  double Way(size_t i) const {
    double way = 0;
    for (size_t k = 1; k <= i; ++k) {
      way += (pairs_[k].truth.Matrix() - pairs_[k - 1].truth.Matrix()).col(3).norm();
    }
    return way;
  }
  Eigen::Matrix4d Error(size_t i, size_t j) const {
    const Eigen::Matrix4d q = pairs_[i].truth.Matrix().inverse() * pairs_[j].truth.Matrix();
    const Eigen::Matrix4d p = pairs_[i].estimate.Matrix().inverse() * pairs_[j].estimate.Matrix();
    return q.inverse() * p;
  }
  static double Metres(const Eigen::Matrix4d& e) { return e.col(3).head<3>().norm(); }
  static double Degrees(const Eigen::Matrix4d& e) {
    const double cosine = (e.topLeftCorner<3, 3>().trace() - 1) / 2;
    return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / M_PI;
  }

  const std::vector<PosePair>& pairs_;
};

TEST(SegmentLengths, AreKittisUnlessTheDriveIsShort) {
  EXPECT_EQ(SegmentLengths(5000), (std::vector<double>{100, 200, 300, 400, 500, 600, 700, 800}));
  EXPECT_EQ(SegmentLengths(350), (std::vector<double>{100, 200, 300}));
  EXPECT_EQ(SegmentLengths(110), (std::vector<double>{10, 20, 30, 40, 50, 60, 70, 80}));
  EXPECT_EQ(SegmentLengths(30), (std::vector<double>{2, 4, 6, 8, 10, 12, 14, 16}));
  EXPECT_TRUE(SegmentLengths(0).empty());
}

TEST(CompareSegments, ALongerEstimateErrsByItsShare) {
  // 1000 m in steps of 1 m, 1 % too long: segments end at the first pose beyond their length.
  const DriftErrors drift = CompareSegments(Straight(1001, 1, 1.01));
  EXPECT_TRUE(drift.is_kitti);
  EXPECT_EQ(drift.stride, 10u);
  ASSERT_EQ(drift.lengths.size(), 8u);
  // From every tenth of 0 ... 899, as 100 m are exceeded by the pose 101 m on.
  EXPECT_EQ(drift.lengths[0].percent.size(), 90u);
  EXPECT_NEAR(drift.lengths[0].percent[0], 1.01, 1e-9);
  EXPECT_NEAR(drift.lengths[7].percent[0], 100 * 8.01 / 800, 1e-9);
  EXPECT_NEAR(drift.deg_per_100m, 0, 1e-6);
}

TEST(CompareSegments, AShortDriveHasShortSegmentsAndSaysSo) {
  const DriftErrors drift = CompareSegments(Straight(301, 0.1, 1.02));
  EXPECT_FALSE(drift.is_kitti);
  EXPECT_EQ(drift.stride, 1u);
  ASSERT_EQ(drift.lengths.size(), 8u);
  EXPECT_DOUBLE_EQ(drift.lengths[0].length_m, 2);
  EXPECT_NEAR(drift.percent, 2, 0.05);
}

TEST(CompareSegments, AgreesWithBruteForce) {
  const std::vector<PosePair> pairs = Drifting(700, 0.9);
  const BruteForce brute(pairs);
  const DriftErrors drift = CompareSegments(pairs);
  double percent = 0, degrees = 0;
  int count = 0;
  for (double length = 100; length <= 800; length += 100) {
    for (size_t i = 0; i < pairs.size(); i += 10) {
      size_t j = i;
      while (j < pairs.size() && !(0.9 * static_cast<double>(j - i) > length + 1e-6)) ++j;
      if (j == pairs.size()) continue;
      percent += 100 * BruteForce::Metres(brute.Error(i, j)) / length;
      degrees += 100 * BruteForce::Degrees(brute.Error(i, j)) / length;
      ++count;
    }
  }
  size_t segments = 0;
  for (const SegmentErrors& errors : drift.lengths) segments += errors.percent.size();
  EXPECT_NEAR(static_cast<double>(segments), count, 8) << "ways that are sums may miss by one";
  EXPECT_NEAR(drift.percent, percent / count, 0.01);
  EXPECT_NEAR(drift.deg_per_100m, degrees / count, 0.01);
}

TEST(CompareSteps, PerFrameMetreAndSecondByHand) {
  // 0.5 m per 0.1 s, 10 % too long.
  const std::vector<PosePair> pairs = Straight(21, 0.5, 1.1);
  const RelativeErrors frames = CompareSteps(pairs, {1, DeltaUnit::kFrames});
  EXPECT_EQ(frames.m.count, 20u);
  EXPECT_NEAR(frames.m.rmse, 0.05, 1e-12);
  const RelativeErrors metres = CompareSteps(pairs, {1, DeltaUnit::kMetres});
  EXPECT_EQ(metres.m.count, 19u);
  EXPECT_NEAR(metres.m.max, 0.1, 1e-12);
  const RelativeErrors seconds = CompareSteps(pairs, {1, DeltaUnit::kSeconds});
  EXPECT_EQ(seconds.m.count, 11u);
  EXPECT_NEAR(seconds.m.median, 0.5, 1e-12);
  EXPECT_EQ(CompareSteps(pairs, {11, DeltaUnit::kMetres}).m.count, 0u);
}

TEST(CompareSteps, AgreesWithBruteForce) {
  const std::vector<PosePair> pairs = Drifting(120, 0.3);
  const BruteForce brute(pairs);
  std::vector<double> m, deg;
  for (size_t i = 0; i < pairs.size(); ++i) {
    for (size_t j = i + 1; j < pairs.size(); ++j) {
      if (brute.Way(j) - brute.Way(i) < 2 - 1e-9) continue;
      m.push_back(BruteForce::Metres(brute.Error(i, j)));
      deg.push_back(BruteForce::Degrees(brute.Error(i, j)));
      break;
    }
  }
  const RelativeErrors errors = CompareSteps(pairs, {2, DeltaUnit::kMetres});
  EXPECT_EQ(errors.m.count, m.size());
  EXPECT_NEAR(errors.m.rmse, Summarize(m).rmse, 1e-9);
  EXPECT_NEAR(errors.m.median, Summarize(m).median, 1e-9);
  EXPECT_NEAR(errors.deg.mean, Summarize(deg).mean, 1e-5);
}

TEST(Summarize, ByHand) {
  const Statistics s = Summarize({4, 0, 2, 2});
  EXPECT_EQ(s.count, 4u);
  EXPECT_DOUBLE_EQ(s.mean, 2);
  EXPECT_DOUBLE_EQ(s.median, 2);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(6));
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(2));
  EXPECT_DOUBLE_EQ(s.min, 0);
  EXPECT_DOUBLE_EQ(s.max, 4);
  EXPECT_DOUBLE_EQ(Summarize({1, 2, 3, 10}).median, 2.5);
  EXPECT_EQ(Summarize({}).count, 0u);
}

TEST(Evaluate, MovesEstimatesIntoTheTruthsFrameAndFindsTheTransform) {
  const Pose T = Pose::FromXyzRpy(10, -20, 3, 0.1, -0.4, 2.0);
  Trajectory truth, estimate;
  for (const PosePair& pair : Drifting(300, 0.2)) {
    truth.push_back({pair.stamp_ns, pair.truth});
    estimate.push_back({pair.stamp_ns, T * pair.truth});
  }
  for (const Alignment alignment : {Alignment::kRigid, Alignment::kFirstPose}) {
    EvaluationOptions options;
    options.alignment = alignment;
    const auto evaluation = Evaluate({{"a", truth, estimate}}, options);
    ASSERT_TRUE(evaluation.ok()) << evaluation.status();
    const EvaluatedTrajectory& robot = evaluation->robots[0];
    EXPECT_LT(Log(robot.T_truth_estimate * T).norm(), 1e-9);
    EXPECT_LT(robot.absolute.max_m, 1e-9);
    EXPECT_LT(robot.per_frame.m.max, 1e-9);
    EXPECT_LT(PositionError(robot.pairs.back()), 1e-9);
    EXPECT_NEAR(robot.way_m, 299 * 0.2, 0.01);
    EXPECT_NEAR(robot.duration_s, 29.9, 1e-9);
  }
  EXPECT_FALSE(Evaluate({}).ok());
}

}  // namespace
}  // namespace isthmus::evaluation
