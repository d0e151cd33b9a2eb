#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "lab/bench/merging/temporary_folder.h"
#include "lab/bench/wild/wild_benchmark.h"
#include "lab/bench/wild/wild_judge.h"

namespace isthmus::bench {
namespace {

// A drive of half a metre a scan and more along a bend, without error, in one segment.
std::vector<ScanRecord> Perfect(int scans) {
  const Pose T_odom_world = Pose::FromXyzRpy(4, -2, 1, 0.1, 0.2, 2).Inverse();
  std::vector<ScanRecord> drive(scans);
  for (int i = 0; i < scans; ++i) {
    drive[i].outcome = ScanOutcome::kOk;
    drive[i].ms = 3;
    drive[i].T_world_sensor = Pose::FromXyzRpy(0.5 * i, 0.002 * i * i, 1, 0, 0, 0.008 * i);
    drive[i].T_odom_sensor = T_odom_world * drive[i].T_world_sensor;
  }
  return drive;
}

// From `begin` on what is said lies `by` farther along odom's x.
void Slip(std::vector<ScanRecord>* drive, size_t begin, double by) {
  for (size_t i = begin; i < drive->size(); ++i) {
    (*drive)[i].T_odom_sensor = Pose(Eigen::Vector3d(by, 0, 0)) * (*drive)[i].T_odom_sensor;
  }
}

TEST(JudgeWild, FindsNothingWhereThereIsNothing) {
  const WildScore score = ScoreWildDrive(Perfect(300), 0.1);
  EXPECT_EQ(score.ok, 300);
  EXPECT_EQ(score.silent, 0);
  EXPECT_EQ(score.segments, 1);
  EXPECT_LT(score.rmse_m, 1e-6);
  EXPECT_GT(score.path_length_m, 149);
  EXPECT_EQ(score.longest_lost_s, 0);
  EXPECT_EQ(score.median_ms, 3);
}

TEST(JudgeWild, CountsSilentScansOverTheLastTenMetres) {
  auto drive = Perfect(300);
  Slip(&drive, 100, 1);
  const WildScore slipped = ScoreWildDrive(drive, 0.1);
  EXPECT_NEAR(slipped.silent, 10 / std::hypot(0.5, 0.4), 2);  // So many in ten metres.
  EXPECT_EQ(slipped.silent_untold, slipped.silent);
  EXPECT_GT(slipped.rmse_m, 0.1);
  auto little = Perfect(300);
  Slip(&little, 100, 0.3);
  EXPECT_EQ(ScoreWildDrive(little, 0.1).silent, 0);
  // A robot that says that it does not know has told.
  drive[100].outcome = ScanOutcome::kDegenerate;
  EXPECT_GT(ScoreWildDrive(drive, 0.1).silent, 10);
  EXPECT_EQ(ScoreWildDrive(drive, 0.1).silent_untold, 0);
  // Scans that are not ok claim nothing.
  for (int i = 100; i < 130; ++i) drive[i].outcome = ScanOutcome::kLost;
  EXPECT_GT(ScoreWildDrive(drive, 0.1).silent,
            0);  // But then it claims to be back where it is not.
}

TEST(JudgeWild, OneAskewScanIsNotManyWrongOnes) {
  auto drive = Perfect(300);
  drive[100].T_odom_sensor = drive[100].T_odom_sensor * Pose::FromXyzRpy(0, 0, 0, 0, 0, 0.1);
  EXPECT_EQ(ScoreWildDrive(drive, 0.1).silent, 0);
}

TEST(JudgeWild, CountsLostScansWhosePoseIsRight) {
  auto drive = Perfect(300);
  Slip(&drive, 50, 2);  // Errors from before are not the loss's fault.
  for (size_t i = 100; i < 110; ++i) drive[i].outcome = ScanOutcome::kLost;
  EXPECT_EQ(ScoreWildDrive(drive, 0.1).lost_though_right, 10);
  Slip(&drive, 105, 0.06);
  EXPECT_EQ(ScoreWildDrive(drive, 0.1).lost_though_right, 5);
  drive[100].T_odom_sensor = drive[100].T_odom_sensor * Pose::FromXyzRpy(0, 0, 0, 0, 0, 0.03);
  EXPECT_EQ(ScoreWildDrive(drive, 0.1).lost_though_right, 4);
  // Lost before it knew anything; in a frame of its own.
  auto never = Perfect(20);
  for (size_t i = 0; i < 20; ++i) {
    if (i < 5 || i > 15) never[i].outcome = ScanOutcome::kLost;
    never[i].segment = i > 15;
  }
  EXPECT_EQ(ScoreWildDrive(never, 0.1).lost_though_right, 0);
}

TEST(JudgeWild, JudgesSegmentsByThemselves) {
  auto drive = Perfect(300);
  Slip(&drive, 100, 50);
  for (size_t i = 100; i < drive.size(); ++i) drive[i].segment = 1;
  const WildScore score = ScoreWildDrive(drive, 0.1);
  EXPECT_EQ(score.segments, 2);
  EXPECT_EQ(score.silent, 0);
  EXPECT_LT(score.rmse_m, 1e-6);
}

TEST(JudgeWild, CountsLongStretchesOfLostScans) {
  auto drive = Perfect(300);
  for (int i = 50; i < 70; ++i) drive[i].outcome = ScanOutcome::kLost;  // Two seconds are not long.
  EXPECT_EQ(ScoreWildDrive(drive, 0.1).lost_long, 0);
  EXPECT_NEAR(ScoreWildDrive(drive, 0.1).longest_lost_s, 2, 1e-9);
  drive[70].outcome = ScanOutcome::kRejected;
  for (int i = 270; i < 300; ++i) drive[i].outcome = ScanOutcome::kLost;
  EXPECT_NEAR(ScoreWildDrive(drive, 0.1).lost_long, 51 / 300.0, 1e-9);
  EXPECT_NEAR(ScoreWildDrive(drive, 0.1).longest_lost_s, 3, 1e-9);
}

TEST(WildRide, IsTheSameFromTheCache) {
  const TemporaryFolder folder;
  const simulation::WildOptions options{"house", "vlp16", 0.5};
  const auto fresh = GetWildRide(6, options, "");
  const auto made = GetWildRide(6, options, folder.path());
  const auto kept = GetWildRide(6, options, folder.path());
  ASSERT_TRUE(fresh.ok() && made.ok() && kept.ok()) << kept.status();
  EXPECT_EQ(kept->about, fresh->about);
  EXPECT_EQ(kept->carrier, fresh->carrier);
  EXPECT_EQ(kept->drive.sensor, "vlp16");
  ASSERT_EQ(kept->drive.shots.size(), 5u);
  for (int turn = 0; turn < 5; ++turn) {
    const Scan a = fresh->drive.scan_of(turn), b = kept->drive.scan_of(turn);
    ASSERT_EQ(a.points.size(), b.points.size());
    for (size_t i = 0; i < a.points.size(); ++i) {
      ASSERT_EQ(a.points[i].x, b.points[i].x);
      ASSERT_EQ(a.points[i].z, b.points[i].z);
      ASSERT_EQ(a.points[i].time, b.points[i].time);
      ASSERT_EQ(a.points[i].intensity, b.points[i].intensity);
      ASSERT_EQ(a.points[i].ring, b.points[i].ring);
    }
    EXPECT_EQ(fresh->drive.shots[turn].end_stamp_ns, kept->drive.shots[turn].end_stamp_ns);
    EXPECT_EQ(a.sequence, b.sequence);
    EXPECT_TRUE(b.has_ring && b.has_time);
    EXPECT_LT(RotationAngle(fresh->drive.truth_of(turn).Inverse() * kept->drive.truth_of(turn)),
              1e-12);
  }
}

TEST(WildRide, SaysWhenAFileIsDamaged) {
  const TemporaryFolder folder;
  const simulation::WildOptions options{"house", "vlp16", 0.2};
  ASSERT_TRUE(GetWildRide(6, options, folder.path()).ok());
  for (const auto& file : std::filesystem::directory_iterator(folder.path())) {
    std::filesystem::resize_file(file.path(), file.file_size() - 1);
  }
  EXPECT_EQ(GetWildRide(6, options, folder.path()).status().code(), absl::StatusCode::kDataLoss);
}

TEST(WildBenchmark, DrawsOtherDrivesEveryTimeAndTheSameOnesBySeed) {
  WildBenchmarkOptions options;
  options.drives = 1;
  options.drawn = {"house", "vlp16", 0.3};
  const auto any = RunWildDrives(options, {}), others = RunWildDrives(options, {});
  ASSERT_TRUE(any.ok() && others.ok());
  EXPECT_NE((*any)[0].seed, (*others)[0].seed);
  options.drives = 2;
  options.seed = 4;
  options.jobs = 2;
  const auto these = RunWildDrives(options, {});
  ASSERT_TRUE(these.ok());
  EXPECT_EQ((*these)[0].seed, 4u);
  EXPECT_EQ((*these)[1].seed, 5u);
  EXPECT_EQ((*these)[1].score.scans, 3);
  options.drawn.kind = "moon";
  EXPECT_EQ(RunWildDrives(options, {}).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace isthmus::bench
