#include "lab/simulation/worlds/another_day.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/file_io.h"
#include "lab/simulation/recording.h"
#include "lab/simulation/sensors/ray_caster.h"
#include "lab/simulation/simulator.h"

namespace isthmus::simulation {
namespace {

using ::testing::HasSubstr;

// The end of a ray straight down into the middle of a box, metres below its top; the box is in the
// world if that is less than its height.
double BelowTop(const RayCaster& caster, const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d middle = box.center();
  const Ray ray{Eigen::Vector3d(middle.x(), middle.y(), box.max().z() + 0.02).cast<float>(),
                Eigen::Vector3f(0, 0, -1)};
  Hit hit;
  caster.Cast({&ray, 1}, 10, {&hit, 1});
  return hit.range_m;
}

class AnotherDay : public ::testing::TestWithParam<std::string> {};

TEST_P(AnotherDay, WhatWentIsGoneAndWhatCameIsThere) {
  const World before = *MakeWorld(GetParam(), 3);
  World after = before;
  Random random(5);
  const auto volumes = MoveFurniture(20, random, &after);
  ASSERT_TRUE(volumes.ok()) << volumes.status();
  const RayCaster old_caster(before.mesh), new_caster(after.mesh);
  int came = 0, went = 0;
  for (const MovedVolume& volume : *volumes) {
    EXPECT_GT(volume.bounds.sizes().maxCoeff(), 0.3);
    ++(volume.came ? came : went);
    const RayCaster& there = volume.came ? new_caster : old_caster;
    const RayCaster& not_there = volume.came ? old_caster : new_caster;
    const double height = volume.bounds.sizes().z();
    EXPECT_LT(BelowTop(there, volume.bounds), height);
    const double free = BelowTop(not_there, volume.bounds);
    EXPECT_TRUE(free < 0 || free > height - 0.1) << free << " of " << height;
  }
  EXPECT_GT(came, 8);
  EXPECT_GT(went, 8);
  EXPECT_GE(came + went, 20);
}

TEST_P(AnotherDay, NothingStandsWhereRobotsDrive) {
  World world = *MakeWorld(GetParam(), 4);
  Random random(6);
  const auto volumes = MoveFurniture(20, random, &world);
  ASSERT_TRUE(volumes.ok()) << volumes.status();
  for (const MovedVolume& volume : *volumes) {
    if (volume.came && volume.bounds.min().z() < 0.05) {
      EXPECT_GT(world.roads.Distance(volume.bounds.center().head<2>()), 0.95);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Worlds, AnotherDay, ::testing::Values("museum", "warehouse"),
                         [](const auto& test) { return test.param; });

TEST(AnotherDayOfSimulator, DrivesElsewhereADayLater) {
  Options options{.seconds = 1};
  const auto monday = *Simulator::Create(options);
  options.day = 2;
  const auto still = *Simulator::Create(options);
  EXPECT_TRUE(still->moved().empty());
  EXPECT_EQ(still->world().mesh.vertices, monday->world().mesh.vertices);
  EXPECT_EQ(still->Stamp(0, 3) - monday->Stamp(0, 3), int64_t{86400} * 1'000'000'000);
  EXPECT_GT((still->PoseAt(0, 0).translation() - monday->PoseAt(0, 0).translation()).norm(), 0.01);
  options.moved = 5;
  const auto moved = *Simulator::Create(options);
  EXPECT_GE(moved->moved().size(), 5u);
  EXPECT_EQ(moved->PoseAt(0, 1).Matrix(), still->PoseAt(0, 1).Matrix());
}

TEST(AnotherDayOfSimulator, RefusesWhatMakesNoSense) {
  const auto refused = [](Options options) {
    const auto simulator = Simulator::Create(options);
    EXPECT_EQ(simulator.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(simulator.status().message());
  };
  EXPECT_THAT(refused({.moved = 1}), HasSubstr("--day 2"));
  EXPECT_THAT(refused({.day = 0}), HasSubstr("1 to 365"));
  EXPECT_THAT(refused({.world = "campus", .day = 2, .moved = 1}), HasSubstr("museum"));
  EXPECT_THAT(refused({.world = "museum", .day = 2, .moved = 100000}), HasSubstr("0 to "));
  EXPECT_THAT(refused({.world = "wild-road", .robots = 1, .day = 2}), HasSubstr("one day"));
}

TEST(AnotherDayOfSimulator, RecordingListsWhatMoved) {
  const std::string dir = ::testing::TempDir() + "another_day";
  std::filesystem::remove_all(dir);
  const Options options{.robots = 1, .seconds = 0.2, .day = 2, .moved = 3};
  ASSERT_TRUE(Record(options, dir).ok());
  EXPECT_THAT(*io::ReadFile(dir + "/moved.truth.json"),
              HasSubstr("\"kind\": \"came\", \"min\": ["));
  EXPECT_THAT(*io::ReadFile(dir + "/simulation.json"), HasSubstr("\"moved\": 3"));
  std::filesystem::remove_all(dir);
}

}  // namespace
}  // namespace isthmus::simulation
