#include "lab/bench/summary.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/angles.h"

namespace isthmus::bench {
namespace {

// A drive along a bend that was estimated without error, in an odom frame of its own.
struct Perfect {
  Drive drive;
  RunRecord run;

  explicit Perfect(int scans = 500) {
    const Pose T_odom_world = Pose::FromXyzRpy(4, -2, 1, 0.1, 0.2, 2).Inverse();
    drive.shots = InOrder(scans, 0.1);
    run.cal_ms = 80;
    for (int i = 0; i < scans; ++i) {
      ScanRecord& scan = run.scans.emplace_back();
      scan.outcome = ScanOutcome::kOk;
      scan.T_world_sensor = Pose::FromXyzRpy(15 + 0.1 * i, 0.002 * i * i / 10., 1, 0, 0, 0.004 * i);
      scan.T_odom_sensor = T_odom_world * scan.T_world_sensor;
      scan.ms = 1 + i % 10;
    }
  }
  // Moves what was said by an error in the world frame.
  void Disturb(int i, const Pose& error) {
    const Pose T_odom_world = run.scans[0].T_odom_sensor * run.scans[0].T_world_sensor.Inverse();
    const Pose& truth = run.scans[i].T_world_sensor;
    run.scans[i].T_odom_sensor = T_odom_world * Pose(error.rotation() * truth.rotation(),
                                                     truth.translation() + error.translation());
  }
};

TEST(Percentile, IsTheNearestRank) {
  EXPECT_EQ(Percentile({}, 0.5), 0);
  EXPECT_EQ(Percentile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(Percentile({4, 3, 1, 2}, 0.5), 2);
  EXPECT_EQ(Percentile({4, 3, 1, 2}, 0.99), 4);
  EXPECT_EQ(Percentile({4, 3, 1, 2}, 0), 1);
}

TEST(Summarize, FindsNoErrorWhereThereIsNone) {
  const Perfect perfect;
  const Summary summary = Summarize(perfect.drive, perfect.run, false);
  EXPECT_LT(summary.error.rmse_m, 1e-9);
  EXPECT_LT(summary.error.first_worst_m, 1e-9);
  EXPECT_LT(summary.error.heading_worst_deg + summary.error.tilt_worst_deg, 1e-6);
  EXPECT_EQ(summary.counts.ok, 500);
  EXPECT_EQ(summary.counts.silent, 0);
  EXPECT_EQ(summary.cost.median_ms, 5);
  EXPECT_EQ(summary.cost.max_ms, 10);
  EXPECT_FALSE(summary.corridor.has_value());
  EXPECT_FALSE(summary.scans_to_recover.has_value());
}

TEST(Summarize, TellsHeadingFromTilt) {
  Perfect drive;
  drive.Disturb(100, Pose::FromXyzRpy(0, 0, 0, 0, 0, 3 * kRadPerDeg));
  drive.Disturb(200, Pose::FromXyzRpy(0, 0, 0, 2 * kRadPerDeg, 0, 0));
  const ErrorSummary error = Summarize(drive.drive, drive.run, false).error;
  EXPECT_NEAR(error.heading_worst_deg, 3, 1e-6);
  EXPECT_NEAR(error.tilt_worst_deg, 2, 1e-6);
  EXPECT_NEAR(error.heading_rmse_deg, 3 / std::sqrt(500), 1e-6);
  EXPECT_LT(error.worst_m, 1e-9);
}

TEST(Summarize, CountsAsSilentWhatIsWrongAndClaimsToBeOk) {
  Perfect drive;
  const Pose wrong(Eigen::Vector3d(0, 0, 0.5));
  for (const int i : {100, 101, 102, 103}) drive.Disturb(i, wrong);
  drive.run.scans[101].outcome = ScanOutcome::kDegenerate;
  drive.run.scans[102].outcome = ScanOutcome::kLost;
  drive.run.scans[103].outcome = ScanOutcome::kRejected;
  const Summary summary = Summarize(drive.drive, drive.run, false);
  EXPECT_EQ(summary.counts.silent, 1);
  EXPECT_EQ(summary.counts.ok, 497);
  EXPECT_EQ(summary.counts.degenerate, 1);
  EXPECT_EQ(summary.counts.lost, 1);
  EXPECT_EQ(summary.counts.rejected, 1);
  // The lost and the rejected one claim nothing, and so are in no error.
  EXPECT_NEAR(summary.error.first_rmse_m, std::sqrt(2 * 0.25 / 498), 1e-9);
}

TEST(Summarize, SegmentsShareNoFrame) {
  Perfect drive;
  for (ScanRecord& scan : drive.run.scans) scan.segment = 1;
  for (int i = 200; i < 500; ++i) {
    ScanRecord& scan = drive.run.scans[i];
    scan.segment = 2;
    scan.T_odom_sensor = Pose::FromXyzRpy(-70, 8, 2, 0, 0.1, 1) * scan.T_odom_sensor;
  }
  const Summary summary = Summarize(drive.drive, drive.run, false);
  EXPECT_EQ(summary.counts.segments, 2);
  EXPECT_EQ(summary.counts.silent, 0);
  EXPECT_LT(summary.error.first_worst_m, 1e-6);
  EXPECT_LT(summary.error.worst_m, 1e-6);
}

TEST(Summarize, CountsScansUntilThePoseIsRightAgain) {
  Perfect drive;
  drive.drive.trouble_ends = 200;
  for (int i = 180; i < 207; ++i) drive.run.scans[i].outcome = ScanOutcome::kLost;
  drive.Disturb(207, Pose(Eigen::Vector3d(1, 0, 0)));
  EXPECT_EQ(Summarize(drive.drive, drive.run, false).scans_to_recover, 8);
  for (int i = 200; i < 500; ++i) drive.run.scans[i].outcome = ScanOutcome::kLost;
  EXPECT_EQ(Summarize(drive.drive, drive.run, false).scans_to_recover, -1);
}

TEST(Summarize, TellsGrowthOfCost) {
  Perfect drive;
  for (int i = 400; i < 500; ++i) drive.run.scans[i].ms = 20;
  const CostSummary cost = Summarize(drive.drive, drive.run, false).cost;
  EXPECT_EQ(cost.early_ms, 5);
  EXPECT_EQ(cost.late_ms, 20);
  EXPECT_FALSE(Summarize(Perfect(300).drive, Perfect(300).run, false).cost.early_ms.has_value());
}

TEST(Summarize, ComparesCostsOfLostScansWithOthers) {
  Perfect drive;
  for (ScanRecord& scan : drive.run.scans) scan.ms = 2;
  EXPECT_FALSE(Summarize(drive.drive, drive.run, false).cost.lost_ratio.has_value());
  for (int i = 100; i < 150; ++i) {
    drive.run.scans[i].outcome = ScanOutcome::kLost;
    drive.run.scans[i].ms = i < 125 ? 1 : 5;
  }
  EXPECT_EQ(Summarize(drive.drive, drive.run, false).cost.lost_ratio, 1.5);
}

TEST(Summarize, SplitsErrorsInACorridor) {
  Perfect drive;
  drive.Disturb(50, Pose(Eigen::Vector3d(-2, 0.1, 0.03)));
  drive.Disturb(499, Pose(Eigen::Vector3d(0, 7, 0)));  // At x = 65: still in it.
  for (int i = 0; i < 250; ++i) {
    drive.run.scans[i].unobserved = {drive.run.scans[i].T_world_sensor.rotation().inverse() *
                                     Eigen::Vector3d::UnitX()};
  }
  drive.run.scans[300].unobserved = {drive.run.scans[300].T_world_sensor.rotation().inverse() *
                                     Eigen::Vector3d::UnitY()};
  const auto corridor = Summarize(drive.drive, drive.run, true).corridor;
  ASSERT_TRUE(corridor.has_value());
  EXPECT_NEAR(corridor->along_worst_m, 2, 1e-9);
  EXPECT_NEAR(corridor->across_worst_m, 7, 1e-9);
  EXPECT_NEAR(corridor->height_worst_m, 0.03, 1e-9);
  EXPECT_NEAR(corridor->flagged, 0.5, 1e-9);
}

TEST(Summarize, LooksAtEachLap) {
  Perfect drive;
  drive.drive.lap_begins = 20;
  drive.drive.lap_shots = 200;
  drive.run.scans[219].heap_mb = 5;
  drive.run.scans[410].heap_mb = 6;
  drive.Disturb(300, Pose(Eigen::Vector3d(0, 0, 0.1)));
  const auto laps = Summarize(drive.drive, drive.run, false).laps;
  ASSERT_EQ(laps.size(), 2u);  // The third is not complete.
  EXPECT_EQ(laps[0].odometry_mb, 5);
  EXPECT_EQ(laps[1].odometry_mb, 6);
  EXPECT_LT(laps[0].rmse_m, 1e-9);
  EXPECT_NEAR(laps[1].rmse_m, 0.1 / std::sqrt(200), 1e-9);
}

}  // namespace
}  // namespace isthmus::bench
