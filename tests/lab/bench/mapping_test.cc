#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include "lab/bench/mapping/report.h"

namespace isthmus::bench {
namespace {

constexpr int kPerLap = 12, kKeyframes = 4;
constexpr double kRadius = 12;

// The sensor on a circle, one submap on.
Pose OnCircle(double submap) {
  const double angle = 2 * std::numbers::pi * submap / kPerLap;
  return Pose::FromXyzRpy(kRadius * std::cos(angle), kRadius * std::sin(angle), 0, 0, 0,
                          angle + std::numbers::pi / 2);
}

// Goes around and around, counter-clockwise; odometry is perfect and begins at the start.
DrivenRobot Around(int submaps) {
  DrivenRobot robot;
  robot.ground = "circle-1";
  robot.session.sensor = "vlp16";
  robot.session.robot = RobotId("robot");
  robot.session.id = SessionId("robot-1");
  simulation::Random random(3);
  for (int i = 0; i < submaps; ++i) {
    auto submap = std::make_shared<Submap>();
    submap->id = {robot.session.id, static_cast<uint32_t>(i)};
    submap->robot = robot.session.robot;
    submap->T_odom_submap = OnCircle(0).Inverse() * OnCircle(i);
    for (int k = 0; k < kKeyframes; ++k) {
      const Pose T_world_sensor = OnCircle(i + static_cast<double>(k) / kKeyframes);
      const auto sequence = static_cast<uint64_t>(i * kKeyframes + k) + 1;
      const auto stamp = static_cast<int64_t>(sequence) * 1'000'000'000;
      submap->keyframes.push_back({sequence, stamp, OnCircle(i).Inverse() * T_world_sensor});
      robot.poses.push_back({sequence, stamp, static_cast<uint32_t>(i), T_world_sensor,
                             OnCircle(0).Inverse() * T_world_sensor});
      for (int p = 0; p < 50; ++p) {
        SubmapPoint point;
        point.x = static_cast<float>(random.Uniform(-5, 5));
        point.y = static_cast<float>(random.Uniform(-5, 5));
        point.keyframe = static_cast<uint16_t>(k);
        submap->points.push_back(point);
      }
    }
    submap->first_sequence = submap->keyframes.front().sequence;
    submap->last_sequence = submap->keyframes.back().sequence;
    submap->first_stamp_ns = submap->keyframes.front().stamp_ns;
    submap->last_stamp_ns = submap->keyframes.back().stamp_ns;
    robot.submaps.push_back(std::move(submap));
  }
  return robot;
}

// As a server would have found it, a lap after the first time.
LoopClosure LapLater(uint64_t id, uint32_t a) {
  LoopClosure loop;
  loop.id = id;
  loop.session = SessionId("robot-1");
  loop.submap_a = a;
  loop.submap_b = a + kPerLap;
  const Matrix6d information = 1e4 * Matrix6d::Identity();
  loop.edges.push_back({a, a + kPerLap, Pose(), information});
  return loop;
}

std::vector<LoopClosure> LapsLater(int count) {
  std::vector<LoopClosure> loops;
  for (int i = 0; i < count; ++i) loops.push_back(LapLater(i + 1, i));
  return loops;
}

TEST(LapReplay, GoesOnWhereTheLapBeforeEnded) {
  auto replay = LapReplay::Create(Around(2 * kPerLap), {.drift = {0, 0}, .noise_m = 0});
  ASSERT_TRUE(replay.ok()) << replay.status();
  ASSERT_EQ(replay->submaps(), static_cast<size_t>(kPerLap));
  const Submap first = replay->Next();
  Submap submap = first;
  for (uint32_t i = 1; i <= 3 * kPerLap; ++i) {
    const Submap before = std::exchange(submap, replay->Next());
    EXPECT_EQ(submap.id.index, i);
    EXPECT_GT(submap.first_stamp_ns, before.last_stamp_ns);
    const Pose true_step = replay->TruePose(i - 1).Inverse() * replay->TruePose(i);
    const Pose step = before.T_odom_submap.Inverse() * submap.T_odom_submap;
    EXPECT_LT((true_step.Inverse() * step).translation().norm(), 1e-9);
  }
  EXPECT_LT((first.T_odom_submap.Inverse() * submap.T_odom_submap).translation().norm(), 1e-6);
}

TEST(LapReplay, NoiseAndDriftAreFreshInEveryLap) {
  auto replay = LapReplay::Create(Around(2 * kPerLap), {.noise_m = 0.01, .max_points = 50});
  ASSERT_TRUE(replay.ok()) << replay.status();
  std::vector<Submap> all;
  for (int i = 0; i <= 2 * kPerLap; ++i) all.push_back(replay->Next());
  EXPECT_EQ(all[0].points.size(), 50u);
  const float once = all[0].points[7].x, again = all[kPerLap].points[7].x;
  EXPECT_NE(once, again);
  EXPECT_NEAR(once, again, 0.1);
  const auto gap = [&](int lap) {
    const Pose moved =
        all[(lap - 1) * kPerLap].T_odom_submap.Inverse() * all[lap * kPerLap].T_odom_submap;
    return moved.translation().norm();
  };
  EXPECT_GT(gap(1), 0.01);
  EXPECT_NE(gap(1), gap(2));
}

TEST(LapReplay, NeedsALap) {
  EXPECT_EQ(LapReplay::Create(Around(kPerLap / 2), {}).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(JudgeLoops, TellsFalseOnesFromThoseThatAreOff) {
  const DrivenRobot robot = Around(2 * kPerLap);
  std::vector<Loop> loops(3);
  loops[0].loop = LapLater(1, 0);
  loops[1].loop = LapLater(2, 1);
  loops[1].loop.T_a_b = Pose::FromXyzRpy(0.3, 0, 0, 0, 0, 0);
  loops[2].loop = LapLater(3, 2);
  loops[2].loop.T_a_b = Pose::FromXyzRpy(0, 0, 0, 0, 0, 0.1);
  loops[2].loop.edges[0].T_a_b = loops[2].loop.T_a_b;
  loops[2].edges_used = 1;
  const LoopFigures figures = JudgeLoops(loops, {robot});
  EXPECT_EQ(figures.loops, 3);
  EXPECT_EQ(figures.edges, 3);
  EXPECT_EQ(figures.false_loops, 1);
  EXPECT_EQ(figures.false_edges, 1);
  EXPECT_EQ(figures.false_used, 1);
  EXPECT_NEAR(figures.worst_m, 0.3, 1e-9);
}

TEST(AddFalseLoops, MakesTheShareThatIsAskedFor) {
  const DrivenRobot robot = Around(3 * kPerLap);
  for (const FalseKind kind : {FalseKind::kRandom, FalseKind::kNear, FalseKind::kTwins}) {
    std::vector<LoopClosure> loops = LapsLater(20);
    const size_t added = AddFalseLoops(kind, 0.3, 1, robot, &loops);
    const double share = static_cast<double>(added) / static_cast<double>(20 + added);
    EXPECT_GE(share, 0.3);
    EXPECT_LT(share, 0.4);
    EXPECT_EQ(loops.back().id, loops.size());
    std::vector<LoopClosure> none;
    EXPECT_EQ(AddFalseLoops(kind, 0.3, 1, robot, &none), 0u);
  }
}

TEST(RunFalseLoops, FalseClosuresDoNotBendTheMap) {
  DrivenRobot robot = Around(3 * kPerLap);
  AddDrift({0.5, 0.05}, 1, &robot);
  const FalseLoopsTrial trial =
      RunFalseLoops(robot, LapsLater(2 * kPerLap), FalseKind::kRandom, 0.3, 1, {});
  EXPECT_GE(trial.false_edges, 10u);
  EXPECT_EQ(trial.false_kept, 0u);
  EXPECT_LT(trial.without_m, trial.open_m);
  EXPECT_LT(trial.with_m, 1.2 * trial.without_m);
}

TEST(RunMapTrial, PerfectOdometryMakesAPerfectMap) {
  server::PipelineOptions options;
  options.composition_interval_s = 0;
  const auto trial = RunMapTrial({Around(6)}, {.pipeline = options, .picture = ""});
  ASSERT_TRUE(trial.ok()) << trial.status();
  EXPECT_EQ(trial->submaps, 6u);
  EXPECT_EQ(trial->in_map, 6u);
  EXPECT_TRUE(trial->one_frame);
  EXPECT_LT(trial->map.all_m, 1e-3);
  EXPECT_LT(trial->trajectories.all_m, 1e-3);
  MappingResults results;
  results.maps = {*trial};
  EXPECT_NE(MappingTables(results).find("| 6 | 0.000 | 0.000 | 0.000 |"), std::string::npos);
  EXPECT_EQ(ToJson(results)["maps"][0]["submaps"], 6);
}

TEST(RunLaps, HasARowForEveryFewLaps) {
  server::PipelineOptions options;
  options.composition_interval_s = 0;
  auto replay = LapReplay::Create(Around(2 * kPerLap), {.drift = {0, 0}});
  ASSERT_TRUE(replay.ok()) << replay.status();
  const auto trial = RunLaps(*std::move(replay), 3, 2, options);
  ASSERT_TRUE(trial.ok()) << trial.status();
  ASSERT_EQ(trial->rows.size(), 2u);
  EXPECT_EQ(trial->rows[0].laps, 2);
  EXPECT_EQ(trial->rows[1].laps, 3);
  EXPECT_EQ(trial->rows[1].submaps + trial->rows[1].retired, 3u * kPerLap);
  EXPECT_GT(trial->rows[1].database_mb, 0);
  EXPECT_LT(trial->rows[1].rmse_m, 0.01);
}

TEST(RunUndo, LeavesNothingOfAWrongMatch) {
  server::PipelineOptions options;
  options.composition_interval_s = 0;
  for (const UndoBy how : {UndoBy::kUndoRevision, UndoBy::kWithdrawing}) {
    const auto trial = RunUndo({Around(4), Around(4)}, how, options);
    ASSERT_TRUE(trial.ok()) << trial.status();
    EXPECT_FALSE(trial->merged_before);
    EXPECT_GT(trial->forced_m, 1);
    EXPECT_LT(trial->left_m, 1e-3);
  }
}

TEST(RunNextDay, TheMapOutlivesTheServer) {
  server::PipelineOptions options;
  options.composition_interval_s = 0;
  const auto trial = RunNextDay(Around(4), Around(3), options);
  ASSERT_TRUE(trial.ok()) << trial.status();
  EXPECT_TRUE(trial->same_after_restart);
  EXPECT_FALSE(trial->placed);  // There is nothing to know the place by.
  EXPECT_EQ(trial->submaps, 3u);
}

}  // namespace
}  // namespace isthmus::bench
