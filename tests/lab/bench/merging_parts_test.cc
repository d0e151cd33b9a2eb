#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/angles.h"
#include "lab/bench/merging/calibration_table.h"
#include "lab/bench/merging/judge.h"
#include "lab/bench/merging/known_places.h"
#include "lab/bench/merging/odom_frames.h"
#include "lab/bench/merging/report.h"
#include "lab/bench/merging/seen_surface.h"
#include "lab/bench/merging/wild_teams.h"

namespace isthmus::bench {
namespace {

constexpr int kScans = 20;  // Per submap; one a metre.

// Drives along x from `begin_m`, sees a point beside it at every metre, and has perfect odometry
// with its odom frame at its start.
DrivenRobot Straight(double begin_m, int submaps) {
  DrivenRobot robot;
  robot.ground = "plain-1";
  robot.session.id = SessionId("robot-1");
  for (int i = 0; i < submaps * kScans; ++i) {
    const Pose T_odom_sensor(Eigen::Vector3d(i, 0, 0));
    robot.poses.push_back({static_cast<uint64_t>(i) + 1, i * int64_t{1000},
                           static_cast<uint32_t>(i / kScans),
                           Pose(Eigen::Vector3d(begin_m, 5, 0)) * T_odom_sensor, T_odom_sensor});
  }
  for (int k = 0; k < submaps; ++k) {
    auto submap = std::make_shared<Submap>();
    submap->id = {robot.session.id, static_cast<uint32_t>(k)};
    submap->T_odom_submap = robot.poses[k * kScans].T_odom_sensor;
    submap->first_sequence = robot.poses[k * kScans].sequence;
    submap->last_sequence = submap->first_sequence + kScans - 1;
    for (int j = 0; j < kScans; ++j) {
      submap->keyframes.push_back({submap->first_sequence + j, robot.poses[k * kScans + j].stamp_ns,
                                   Pose(Eigen::Vector3d(j, 0, 0))});
      SubmapPoint point;
      point.x = static_cast<float>(j) + 0.5f;
      point.y = 0.5f;
      point.keyframe = static_cast<uint16_t>(j);
      submap->points.push_back(point);
    }
    robot.submaps.push_back(std::move(submap));
  }
  return robot;
}

void ExpectNear(const Pose& a, const Pose& b) {
  EXPECT_LT((a.Inverse() * b).translation().norm(), 1e-9);
  EXPECT_LT(RotationAngle(a.Inverse() * b), 1e-7);
}

TEST(RandomFrame, IsWithinWhatItSays) {
  double yaw = 0, tilt = 0, far = 0;
  for (uint64_t seed = 0; seed < 200; ++seed) {
    const Pose frame = RandomFrame(seed, 1);
    yaw = std::max(yaw, std::abs(frame.Yaw()));
    tilt = std::max(tilt, std::acos((frame.rotation() * Eigen::Vector3d::UnitZ()).z()));
    far = std::max(far, frame.translation().head<2>().norm());
  }
  EXPECT_GT(yaw, 170 * kRadPerDeg);
  EXPECT_GT(tilt, 5 * kRadPerDeg);  // Roll and pitch together.
  EXPECT_LT(tilt, 7.1 * kRadPerDeg);
  EXPECT_GT(far, 180);
  EXPECT_LE(far, 200);
  ExpectNear(RandomFrame(3, 1), RandomFrame(3, 1));
  EXPECT_GT((RandomFrame(3, 1).Inverse() * RandomFrame(3, 2)).translation().norm(), 1);
}

TEST(MoveOdom, MovesSubmapsAndPosesTogether) {
  const DrivenRobot before = Straight(0, 3);
  DrivenRobot robot = before;
  const Pose X = RandomFrame(7, 1);
  MoveOdom(X, &robot);
  for (size_t i = 0; i < robot.submaps.size(); ++i) {
    ExpectNear(robot.submaps[i]->T_odom_submap, X * before.submaps[i]->T_odom_submap);
  }
  for (size_t i = 0; i < robot.poses.size(); ++i) {
    ExpectNear(robot.poses[i].T_odom_sensor, X * before.poses[i].T_odom_sensor);
    ExpectNear(robot.poses[i].T_world_sensor, before.poses[i].T_world_sensor);
  }
}

TEST(AddDrift, BendsBetweenSubmapsOnly) {
  const DrivenRobot before = Straight(0, 5);
  DrivenRobot robot = before;
  AddDrift({1, 0.1}, 5, &robot);
  ExpectNear(robot.submaps[0]->T_odom_submap, before.submaps[0]->T_odom_submap);
  EXPECT_GT((robot.submaps[4]->T_odom_submap.translation() - Eigen::Vector3d(80, 0, 0)).norm(),
            0.1);
  for (size_t i = 0; i < robot.poses.size(); ++i) {
    const auto relative = [i](const DrivenRobot& r) {
      return r.submaps[r.poses[i].submap]->T_odom_submap.Inverse() * r.poses[i].T_odom_sensor;
    };
    ExpectNear(relative(robot), relative(before));
  }
  DrivenRobot still = before;
  AddDrift({}, 5, &still);
  ExpectNear(still.submaps[4]->T_odom_submap, before.submaps[4]->T_odom_submap);
}

TEST(AddDrift, IsAsLargeAsSaid) {
  double along = 0, height = 0, yaw = 0;
  constexpr int kSeeds = 400;
  const DrivenRobot before = Straight(0, 2);
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    DrivenRobot robot = before;
    AddDrift({2, 0.1}, seed, &robot);
    const Pose error = before.submaps[1]->T_odom_submap.Inverse() * robot.submaps[1]->T_odom_submap;
    along += error.translation().x() * error.translation().x() / kSeeds;
    height += error.translation().z() * error.translation().z() / kSeeds;
    yaw += error.Yaw() * error.Yaw() / kSeeds;
  }
  EXPECT_NEAR(std::sqrt(along), 0.02 * kScans, 0.04);
  EXPECT_NEAR(std::sqrt(height), 0.02 * kScans / 3, 0.015);
  EXPECT_NEAR(std::sqrt(yaw), 0.1 * kRadPerDeg * kScans, 0.2 * kRadPerDeg);
}

TEST(AddAnchors, ErrAsMuchAsTheySay) {
  double squares = 0, turned = 0;
  constexpr int kSeeds = 300;
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    DrivenRobot robot = Straight(100, 4);
    AddAnchors({.gnss_m = 3, .start_m = 0.5}, seed, &robot);
    ASSERT_EQ(robot.anchors.size(), 2u);
    const Anchor &start = robot.anchors[0], &gnss = robot.anchors[1];
    EXPECT_EQ(start.submap, robot.submaps[0]->id);
    EXPECT_EQ(start.sigma_xy_m, 0.5);
    EXPECT_EQ(gnss.submap, robot.submaps[3]->id);
    EXPECT_EQ(gnss.sigma_deg, 0);
    const Eigen::Vector3d error =
        gnss.T_map_submap.translation() - robot.poses[3 * kScans].T_world_sensor.translation();
    squares += error.head<2>().squaredNorm() / (2 * kSeeds);
    turned += start.T_map_submap.Yaw() * start.T_map_submap.Yaw() / kSeeds;
  }
  EXPECT_NEAR(std::sqrt(squares), 3, 0.3);
  EXPECT_NEAR(std::sqrt(turned), 5 * kRadPerDeg, 0.01);
}

TEST(SeenSurface, OverlapIsOfTheOneThatSawLess) {
  const DrivenRobot a = Straight(0, 4), b = Straight(60, 2);  // 0-80 m and 60-100 m.
  const SeenSurface seen_a(a), seen_b(b);
  EXPECT_NEAR(SeenSurface::Overlap(seen_a, seen_b), 0.5, 1e-9);
  EXPECT_NEAR(SeenSurface::Overlap(seen_b, seen_a), 0.5, 1e-9);
  // After 70 scans: 0-70 m and 60-100 m.
  EXPECT_NEAR(SeenSurface::Overlap(seen_a, seen_b, {0, 70}, {0, 70}), 0.25, 1e-9);
  EXPECT_NEAR(SeenSurface::Overlap(seen_a, seen_b, {0, 70}, {21, UINT64_MAX}), 0, 1e-9);
  EXPECT_EQ(SeenSurface::Overlap(seen_a, seen_b, {0, 0}, {}), 0);
}

TEST(SeenSurface, StretchesAreTheLongestInTheRange) {
  const DrivenRobot a = Straight(0, 4), b = Straight(60, 2);
  const auto little = FindScanRanges(a, b, {0.15, 0.25}, false);
  ASSERT_TRUE(little);
  EXPECT_EQ(little->first.last, 70u);
  EXPECT_EQ(little->second.last, 70u);
  EXPECT_FALSE(FindScanRanges(a, b, {0.9, 1}, false));
  const auto apart = FindScanRanges(a, b, {0, 0.02}, true);
  ASSERT_TRUE(apart);
  DrivenRobot cut_a = a, cut_b = b;
  KeepScans(apart->first, &cut_a);
  KeepScans(apart->second, &cut_b);
  EXPECT_EQ(SeenSurface::Overlap(SeenSurface(cut_a), SeenSurface(cut_b)), 0);
}

TEST(Keep, CutsKeyframesPointsAndPoses) {
  DrivenRobot robot = Straight(0, 4);
  KeepScans({0, 50}, &robot);
  ASSERT_EQ(robot.submaps.size(), 3u);
  EXPECT_EQ(robot.submaps[2]->keyframes.size(), 10u);
  EXPECT_EQ(robot.submaps[2]->points.size(), 10u);
  EXPECT_EQ(robot.submaps[2]->last_sequence, 50u);
  EXPECT_EQ(robot.poses.size(), 50u);

  robot = Straight(0, 4);
  KeepScans({30, UINT64_MAX}, &robot);  // Whole submaps only: from the third on.
  ASSERT_EQ(robot.submaps.size(), 2u);
  EXPECT_EQ(robot.submaps[0]->id.index, 0u);
  EXPECT_EQ(robot.submaps[0]->first_sequence, 41u);
  EXPECT_EQ(robot.poses.front().sequence, 41u);
  EXPECT_EQ(robot.poses.front().submap, 0u);
}

TEST(PairTruth, MeasuresWhereBothHaveBeen) {
  const DrivenRobot a = Straight(0, 4);
  DrivenRobot b = Straight(60, 2);
  const Pose X = RandomFrame(3, 1), T_a_b = Pose(Eigen::Vector3d(60, 0, 0)) * X.Inverse();
  MoveOdom(X, &b);
  const PairTruth truth(a, b);
  ASSERT_TRUE(truth.HasTransform() && truth.known());
  EXPECT_NEAR(truth.ErrorOf(T_a_b).median_m, 0, 1e-9);
  EXPECT_NEAR(truth.StartErrorOf(T_a_b).median_m, 0, 1e-9);
  EXPECT_NEAR(truth.drift().median_m, 0, 1e-9);
  const Pose shifted = Pose(Eigen::Vector3d(0, 0.25, 0)) * T_a_b;
  EXPECT_NEAR(truth.ErrorOf(shifted).median_m, 0.25, 1e-9);
  EXPECT_TRUE(truth.IsWithin(shifted, 0.3, 1));
  EXPECT_FALSE(truth.IsWithin(shifted, 0.2, 1));
  const Pose turned = T_a_b * X * Pose::FromXyzRpy(0, 0, 0, 0, 0, 2 * kRadPerDeg) * X.Inverse();
  EXPECT_NEAR(truth.ErrorOf(turned).median_deg, 2, 1e-6);
  EXPECT_FALSE(truth.IsWithin(turned, 10, 1));
}

TEST(PairTruth, DriftOfTheSharedPartIsNobodysError) {
  const DrivenRobot a = Straight(0, 4);
  DrivenRobot b = Straight(0, 4);
  AddDrift({0, 0.1}, 3, &b);
  const PairTruth truth(a, b);
  EXPECT_GT(truth.drift().median_deg, 0.5);
  EXPECT_TRUE(truth.IsWithin(Pose(), 0.01, 0.01));  // Fits where they set out.
  EXPECT_FALSE(truth.IsWithin(Pose(Eigen::Vector3d(0, 0, 30)), 0.3, 1));
}

TEST(PairTruth, NothingIsRightBetweenTwoWorlds) {
  const DrivenRobot a = Straight(0, 1);
  DrivenRobot b = Straight(0, 1);
  b.ground = "plain-2";
  const PairTruth truth(a, b);
  EXPECT_FALSE(truth.HasTransform());
  EXPECT_FALSE(truth.IsWithin(Pose(), 100, 180));
}

TEST(ErrorOfEdges, ComparesSubmapsWithTheirTruth) {
  const DrivenRobot a = Straight(0, 4), b = Straight(60, 2);
  SubmapEdge edge;
  edge.submap_a = 3;
  edge.submap_b = 1;
  edge.T_a_b = Pose(Eigen::Vector3d(20, 0.1, 0));  // At 60 and at 80 m.
  EXPECT_NEAR(ErrorOfEdges(a, b, {edge}).median_m, 0.1, 1e-9);
  EXPECT_EQ(ErrorOfEdges(a, b, {}).median_m, 0);
}

TEST(OverlapBucket, HasItsLowerEnd) {
  EXPECT_EQ(OverlapBucket(0), 0);
  EXPECT_EQ(OverlapBucket(0.049), 0);
  EXPECT_EQ(OverlapBucket(0.05), 1);
  EXPECT_EQ(OverlapBucket(0.2), 2);
  EXPECT_EQ(OverlapBucket(0.29), 3);
  EXPECT_EQ(OverlapBucket(0.45), 4);
  EXPECT_EQ(OverlapBucket(1), 5);
}

TEST(OverlapTable, CountsPairsByWorldAndBucket) {
  Trial trial;
  trial.world = "museum";
  trial.pairs.resize(2);
  trial.pairs[0].overlap = 0.2;
  trial.pairs[0].outcome = TrialOutcome::kRight;
  trial.pairs[1].overlap = 0.22;
  EXPECT_NE(OverlapTable({trial}).find("| museum | 0.15-0.25 | 2 | 1 | 1 | 0 |"),
            std::string::npos);
}

// Four robots of which the first three hang together by pairs of this overlap.
Trial Team(double overlap, std::vector<uint32_t> frames) {
  Trial trial;
  trial.scenario = "mine";
  trial.frames = std::move(frames);
  for (const auto& [a, b] : {std::pair(0, 1), std::pair(1, 2), std::pair(2, 3)}) {
    PairResult& pair = trial.pairs.emplace_back();
    pair.a = a;
    pair.b = b;
    pair.overlap = b == 3 ? 0 : overlap;
  }
  return trial;
}

TEST(WildTeamsTable, CountsThoseThatHangTogetherInOneFrame) {
  const std::string table =
      WildTeamsTable({Team(0.5, {0, 0, 0, 1}), Team(0.5, {0, 0, 1, 2}), Team(0.2, {0, 1, 2, 3})});
  EXPECT_NE(table.find("| mine | 3 | 12 | 1 of 2 | 5 of 6 | 1 of 3 | 5 of 9 |"), std::string::npos)
      << table;
}

TEST(DrawWildTeams, HasTheDrivesOfThePairs) {
  WildPairsOptions options;
  options.worlds = 2;
  options.seed = 7;
  options.robots = 5;
  const auto teams = DrawWildTeams(options);
  ASSERT_TRUE(teams.ok()) << teams.status();
  ASSERT_EQ(teams->size(), 2u);
  ASSERT_EQ(teams->at(1).drives.size(), 5u);
  EXPECT_EQ(teams->at(1).seed, 8u);
  EXPECT_EQ(teams->at(1).drives[4].robot, 4);
  const auto pairs = DrawWildPairs(options);
  const auto last = std::find_if(pairs->begin(), pairs->end(), [](const WildPair& pair) {
    return pair.seed == 8 && pair.a.robot == 3 && pair.b.robot == 4;
  });
  ASSERT_NE(last, pairs->end());
  EXPECT_EQ(teams->at(1).drives[4].Key(), last->b.Key());
}

TEST(Calibrate, ComparesConfidenceWithShareRight) {
  const CalibrationFigures figures =
      Calibrate({{0.95, true}, {1, true}, {0.92, false}, {0.1, false}, {0.15, true}});
  EXPECT_EQ(figures.bins[9].count, 3);
  EXPECT_EQ(figures.bins[9].right, 2);
  EXPECT_NEAR(figures.bins[9].confidence, (0.95 + 1 + 0.92) / 3, 1e-12);
  EXPECT_EQ(figures.bins[1].count, 2);
  EXPECT_EQ(figures.bins[0].count, 0);
  EXPECT_NEAR(figures.brier, (0.05 * 0.05 + 0 + 0.92 * 0.92 + 0.1 * 0.1 + 0.85 * 0.85) / 5, 1e-12);
  EXPECT_NEAR(figures.ece, (2.87 - 2) / 5 + (1 - 0.25) / 5, 1e-12);
  EXPECT_EQ(Calibrate({}).brier, 0);
}

TEST(PrecisionTable, CountsFromEachConfidenceOn) {
  Trial trial;
  const auto add = [&](double overlap, double confidence, bool right) {
    PairResult& pair = trial.pairs.emplace_back();
    pair.overlap = overlap;
    pair.match.confidence = confidence;
    pair.match.candidates = 1;
    pair.match.state = MatchState::kNotYet;
    pair.match.reason = MatchReason::kLoose;
    pair.hypothesis_right = right;
  };
  add(0.5, 0.96, true);
  add(0.5, 0.6, true);
  add(0.1, 0.6, false);
  add(0.4, 0.1, false);
  const std::string table = PrecisionTable({trial});
  EXPECT_NE(table.find("| 0.50 | 3 | 2 | 0.667 | 0.67 |"), std::string::npos) << table;
  EXPECT_NE(table.find("| 0.95 | 1 | 1 | 1.000 | 0.33 |"), std::string::npos) << table;
  EXPECT_NE(ReasonTable({trial}).find("| LOOSE | 3 | 2 | 1 | 0 |"), std::string::npos);
}

}  // namespace
}  // namespace isthmus::bench
