#include "lab/simulation/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/codec/scan_decoder.h"
#include "core/formats/pcd.h"
#include "core/formats/tum.h"
#include "core/io/file_io.h"
#include "lab/simulation/wild/wild.h"

namespace isthmus::simulation {
namespace {

using ::testing::HasSubstr;

// A folder of the test's own, removed at the end.
class Recording : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(dir_); }
  void TearDown() override { std::filesystem::remove_all(dir_); }

  const std::string dir_ =
      ::testing::TempDir() + ::testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(Recording, FilesHoldWhatTheSimulatorMade) {
  Options options;
  options.seconds = 0.5;
  const auto simulator = *Simulator::Create(options);
  std::vector<int> done;
  const auto summary = Record(*simulator, dir_, [&](int i, int total) {
    EXPECT_EQ(total, 10);
    done.push_back(i);
  });
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->scans_per_robot, 5);
  EXPECT_THAT(done, ::testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));

  for (const int robot : {0, 1}) {
    const std::string name = dir_ + "/robot_" + std::to_string(robot);
    const auto file = formats::ReadPcd(name + "/000003.pcd");
    ASSERT_TRUE(file.ok()) << file.status();
    const auto read = codec::DecodeScan(file->payload, 4, 0);
    ASSERT_TRUE(read.ok()) << read.status();
    const Scan made = simulator->MakeScan(robot, 3);
    ASSERT_EQ(read->points.size(), made.points.size());
    EXPECT_TRUE(read->has_ring && read->has_time);
    for (size_t i = 0; i < made.points.size(); ++i) {
      const ScanPoint &a = read->points[i], &b = made.points[i];
      ASSERT_EQ(std::tie(a.x, a.y, a.z, a.intensity, a.ring),
                std::tie(b.x, b.y, b.z, b.intensity, b.ring));
      // The decoder takes the last return for the end of the turn.
      ASSERT_NEAR(a.time - read->points[0].time, b.time - made.points[0].time, 1e-6);
    }
    const auto truth = formats::ReadTum(name + ".truth.tum");
    ASSERT_TRUE(truth.ok()) << truth.status();
    ASSERT_EQ(truth->size(), 5u);
    EXPECT_EQ((*truth)[3].stamp_ns, made.end_stamp_ns);
    EXPECT_LT(Log((*truth)[3].pose.Inverse() * simulator->Truth(robot, 3).pose).norm(), 1e-6);
    EXPECT_THAT(*io::ReadFile(name + "/times.txt"),
                HasSubstr("1600000000.100000000\n1600000000.200000000\n"));
  }
}

TEST_F(Recording, JsonSaysWhatItIs) {
  Options options;
  options.world = "twins";
  options.seconds = 0.2;
  options.seed = 7;
  const auto summary = Record(options, dir_);
  ASSERT_TRUE(summary.ok()) << summary.status();
  const std::string json = *io::ReadFile(dir_ + "/simulation.json");
  EXPECT_THAT(json, HasSubstr("\"world\": \"twins\""));
  EXPECT_THAT(json, HasSubstr("\"seed\": 7"));
  // Two closed rooms apart share nothing; a robot shares everything with itself.
  EXPECT_THAT(json, HasSubstr("\"overlap\": [[1.000, 0.000], [0.000, 1.000]]"));
}

TEST_F(Recording, AWildWorldHasATeam) {
  const Options options{.world = "wild-flat", .robots = 2, .seconds = 2, .seed = 4};
  const auto summary = Record(options, dir_);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_EQ(summary->robots, 2);
  for (const int robot : {0, 1}) {
    const auto drive = DrawWildTeamDrive(
        4, {.kind = "flat", .sensor = "vlp16", .seconds = 2, .first_day = true}, robot);
    const auto truth = formats::ReadTum(dir_ + "/robot_" + std::to_string(robot) + ".truth.tum");
    ASSERT_TRUE(drive.ok() && truth.ok());
    ASSERT_EQ(truth->size(), 20u);
    const Pose& expected = drive->simulator->Truth(0, 7).pose;
    EXPECT_LT(Log((*truth)[7].pose.Inverse() * expected).norm(), 1e-6);
  }
  // Two robots in one flat, on one day, share walls.
  EXPECT_GT(summary->overlap[0][1], 0.02);
}

TEST_F(Recording, FailsWithAnErrorWhereNothingCanBeWritten) {
  std::filesystem::create_directories(dir_);
  ASSERT_TRUE(io::WriteFile(dir_ + "/file", "x").ok());
  Options options;
  options.seconds = 0.1;
  const auto summary = Record(options, dir_ + "/file/below");
  EXPECT_FALSE(summary.ok());
  EXPECT_THAT(std::string(summary.status().message()), HasSubstr("file/below"));
}

}  // namespace
}  // namespace isthmus::simulation
