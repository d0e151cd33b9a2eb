// The commands that bring their own server.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/codec/payload_builder.h"
#include "core/formats/pcd.h"
#include "core/formats/tum.h"
#include "lab/simulation/random.h"
#include "lab/simulation/simulator.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

TEST(Offline, SimulateOdometryAndEvalFitTogether) {
  const std::string folder = ScratchFolder();
  ASSERT_EQ(Isthmus("simulate --world museum --robots 1 --seconds 4 -o " + folder).code, 0);
  const ProgramResult odometry = Isthmus("odometry " + folder + "/robot_0 -o " + folder +
                                         "/odom.tum --timing " + folder + "/timing.csv --json");
  ASSERT_EQ(odometry.code, 0) << odometry.err;
  EXPECT_THAT(odometry.err, Not(HasSubstr("not observed")));
  EXPECT_EQ(json::parse(odometry.out)["poses"], 40);

  std::ifstream timing(folder + "/timing.csv");
  std::string line;
  std::getline(timing, line);
  EXPECT_EQ(line, "scan,features_ms,matching_ms,map_ms,total_ms,segment,tracking");
  int rows = 0;
  while (std::getline(timing, line)) {
    double scan = -1, features = 0, matching = 0, map = 0, total = 0;
    ASSERT_EQ(
        std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf", &scan, &features, &matching, &map, &total),
        5);
    EXPECT_EQ(scan, rows++);
    EXPECT_GT(total, 0);
    EXPECT_TRUE(line.ends_with(",1,ok")) << line;
  }
  EXPECT_EQ(rows, 40);

  const ProgramResult eval = Isthmus("eval --truth " + folder + "/robot_0.truth.tum --estimate " +
                                     folder + "/odom.tum --json");
  ASSERT_EQ(eval.code, 0) << eval.err;
  const json robot = json::parse(eval.out)["robots"][0];
  EXPECT_EQ(robot["poses"], 40);
  EXPECT_LT(robot["rmse_m"], 0.10);
}

TEST(Offline, OdometrySaysSoWhenMostOfItIsExtrapolated) {
  const std::string folder = ScratchFolder();  // A bare field, seen by few rings.
  ASSERT_EQ(
      Isthmus("simulate --world wild-field --robots 1 --seconds 2 --seed 1 -o " + folder).code, 0);
  const ProgramResult odometry =
      Isthmus("odometry " + folder + "/robot_0 -o " + folder + "/odom.tum");
  EXPECT_EQ(odometry.code, 0);
  EXPECT_THAT(odometry.err, HasSubstr("of 20 scans (75 %) a direction was not observed"));
}

TEST(Offline, SimulatePutsWalkersAndCarsAmongTheRobots) {
  const std::string folder = ScratchFolder();
  const auto scan = [&](const std::string& drive, const std::string& traffic) {
    const ProgramResult result = Isthmus("simulate --world campus --robots 1 --seconds 0.2 " +
                                         traffic + " -o " + folder + "/" + drive);
    EXPECT_EQ(result.code, 0) << result.err;
    std::ifstream file(folder + "/" + drive + "/robot_0/000000.pcd", std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const std::string quiet = scan("quiet", "");
  const std::string busy = scan("busy", "--walkers 40 --cars 12 --parked 9");
  EXPECT_FALSE(quiet.empty());
  EXPECT_NE(busy, quiet);
  const json written = json::parse(std::ifstream(folder + "/busy/simulation.json"));
  EXPECT_EQ(written["walkers"], 40);
  EXPECT_EQ(written["cars"], 12);
  EXPECT_EQ(written["parked"], 9);
}

// Pixels of a PNG, and where they lie in the map by the world file beside it: x from and to, then
// y.
std::array<double, 4> ExtentOf(const std::string& folder, const std::string& name) {
  std::ifstream png(folder + "/" + name + ".png", std::ios::binary);
  std::string head(24, 0);
  png.read(head.data(), 24);
  EXPECT_EQ(head.substr(1, 3), "PNG");
  const auto big_endian = [&head](size_t at) {
    int value = 0;
    for (size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<uint8_t>(head[i]);
    return value;
  };
  std::ifstream world(folder + "/" + name + ".pgw");
  double step_x = 0, turn = 0, step_y = 0, x = 0, y = 0;
  world >> step_x >> turn >> turn >> step_y >> x >> y;
  return {x, x + step_x * big_endian(16), y + step_y * big_endian(20), y};
}

TEST(Offline, MergedDrivesHaveTrajectoriesInOneFrameAndAPicture) {
  const std::string folder = ScratchFolder();
  ASSERT_EQ(Isthmus("simulate --world museum --robots 2 --seconds 30 -o " + folder).code, 0);
  const std::string drives = folder + "/robot_0 " + folder + "/robot_1 ";
  const ProgramResult merge =
      Isthmus("merge " + drives + " -o " + folder + "/merged.pcd --trajectories " + folder +
              "/new/ways --picture " + folder + "/merged.png --report " + folder + "/report.json");
  ASSERT_EQ(merge.code, 0) << merge.out << merge.err;
  const std::string ways[] = {folder + "/new/ways/robot_0.tum", folder + "/new/ways/robot_1.tum"};
  const json report = json::parse(std::ifstream(folder + "/report.json"));
  EXPECT_EQ(report["picture"], folder + "/merged.png");
  const auto [x_from, x_to, y_from, y_to] = ExtentOf(folder, "merged");
  for (int robot = 0; robot < 2; ++robot) {
    EXPECT_EQ(report["inputs"][robot]["trajectory"], ways[robot]);
    EXPECT_THAT(merge.out, HasSubstr(ways[robot] + ": 300 poses of robot_"));
    const auto poses = formats::ReadTum(ways[robot]);
    ASSERT_TRUE(poses.ok()) << poses.status();
    for (const StampedPose& entry : *poses) {
      const Eigen::Vector3d at = entry.pose.translation();
      EXPECT_TRUE(at.x() > x_from && at.x() < x_to && at.y() > y_from && at.y() < y_to);
    }
  }
  // One alignment with the truth for both: they are in one frame, and right in it.
  const ProgramResult eval =
      Isthmus("eval --merged --json --truth " + folder + "/robot_0.truth.tum " + folder +
              "/robot_1.truth.tum --estimate " + ways[0] + " " + ways[1]);
  ASSERT_EQ(eval.code, 0) << eval.err;
  EXPECT_EQ(json::parse(eval.out)["merged"]["poses"], 600);
  EXPECT_LT(json::parse(eval.out)["merged"]["rmse_m"], 0.1);
}

// A wall of 4 m and nothing else: no two maps can be told to belong together by it. One point is
// none.
std::string WriteWall(const std::string& path, float y) {
  Cloud cloud{{NAN, y, 0, 1}};
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 20; ++k) cloud.push_back({i * 0.02f, y, k * 0.1f, 1});
  }
  EXPECT_TRUE(
      formats::WritePcd(path, codec::MakePayload(cloud), formats::PcdEncoding::kBinaryCompressed)
          .ok());
  return path;
}

TEST(Offline, MapsWithoutEvidenceAreNotMergedAndTheReportSaysWhy) {
  const std::string folder = ScratchFolder();
  const ProgramResult merge =
      Isthmus("merge " + WriteWall(folder + "/a.pcd", 2) + " " + WriteWall(folder + "/b.pcd", -3) +
              " -o " + folder + "/merged.pcd --report " + folder + "/report.json");
  EXPECT_EQ(merge.code, 3) << merge.out << merge.err;
  EXPECT_THAT(merge.err, HasSubstr("a.pcd: 1 of 4001 points are left out"));
  const json report = json::parse(std::ifstream(folder + "/report.json"));
  EXPECT_EQ(report["merged"], false);
  EXPECT_TRUE(report["file"].is_null());
  ASSERT_EQ(report["pairs"].size(), 1u);
  EXPECT_EQ(report["pairs"][0]["accepted"], false);
  EXPECT_NE(report["pairs"][0]["detail"], "");
  EXPECT_FALSE(std::ifstream(folder + "/merged.pcd").good());
}

// A room of 24 x 14 m in which every thing stands twice, half a turn about the middle apart; seen
// in a frame that is turned by `yaw`.
void WriteRoomBuiltTwice(const std::string& path, double yaw) {
  simulation::Random random(5);
  const Pose T_map_room = Pose::FromXyzRpy(yaw, -0.5 * yaw, 0, 0, 0, yaw);
  Cloud cloud;
  const auto add = [&](double x, double y, double z) {
    const double noise_m = 0.01;
    const Eigen::Vector3d p(x + noise_m * random.Normal(), y + noise_m * random.Normal(),
                            z + noise_m * random.Normal());
    const Eigen::Vector3f q = (T_map_room * p).cast<float>();
    cloud.push_back({q.x(), q.y(), q.z(), 1});
  };
  const auto add_box = [&](double x, double y, double half_x, double half_y, double high,
                           int points) {
    for (int i = 0; i < points; ++i) {
      const double t = random.Uniform(-1, 1), z = random.Uniform(0, high);
      const double side = random.Chance(0.5) ? 1 : -1;
      random.Chance(0.5) ? add(x + t * half_x, y + side * half_y, z)
                         : add(x + side * half_x, y + t * half_y, z);
    }
  };
  add_box(0, 0, 12, 7, 3, 32'000);
  for (int i = 0; i < 30'000; ++i) add(random.Uniform(-12, 12), random.Uniform(-7, 7), 0);
  for (const double turn : {1.0, -1.0}) {
    add_box(turn * 4, turn * 3, 0.6, 0.6, 1.8, 6000);
    add_box(turn * 8, turn * -4, 1, 1, 1.8, 6000);
    add_box(turn * 1.5, turn * -5, 0.4, 0.4, 1.8, 6000);
  }
  ASSERT_TRUE(
      formats::WritePcd(path, codec::MakePayload(cloud), formats::PcdEncoding::kBinaryCompressed)
          .ok());
}

// Nothing tells which way round it lies: either is a guess.
TEST(Offline, MergeReadsEachFileOnceAndWritesOverNone) {
  const std::string folder = ScratchFolder();
  const std::string a = WriteWall(folder + "/a.pcd", 2), b = WriteWall(folder + "/b.pcd", -3);
  const ProgramResult twice =
      Isthmus("merge " + a + " " + folder + "/./a.pcd -o " + folder + "/merged.pcd");
  EXPECT_EQ(twice.code, 2);
  EXPECT_THAT(twice.err, HasSubstr("a.pcd is named twice"));
  for (const std::string& written : {b, folder + "/merged.pcd --report " + b}) {
    const ProgramResult over = Isthmus("merge " + a + " " + b + " -o " + written);
    EXPECT_EQ(over.code, 2) << written;
    EXPECT_THAT(over.err, HasSubstr("b.pcd is one of the files to merge"));
  }
}

TEST(Offline, UnverifiedMapsThatFitTwoWaysAreNotMerged) {
  const std::string folder = ScratchFolder();
  WriteRoomBuiltTwice(folder + "/a.pcd", 0);
  WriteRoomBuiltTwice(folder + "/b.pcd", 0.6);
  const ProgramResult merge =
      Isthmus("merge " + folder + "/a.pcd " + folder + "/b.pcd -o " + folder +
              "/merged.pcd --unverified --report " + folder + "/report.json");
  EXPECT_EQ(merge.code, 8) << merge.out << merge.err;
  EXPECT_FALSE(std::filesystem::exists(folder + "/merged.pcd"));
  const json pair = json::parse(std::ifstream(folder + "/report.json"))["pairs"][0];
  EXPECT_EQ(pair["accepted"], false);
  EXPECT_EQ(pair["reason"], "REASON_AMBIGUOUS");
  ASSERT_FALSE(pair["rivals"].empty());
  EXPECT_GE(pair["rivals"][0]["confidence"], 0.2 * pair["confidence"].get<double>());
  EXPECT_THAT(pair["detail"].get<std::string>(),
              testing::AllOf(HasSubstr("180 deg from it"), HasSubstr("give the trajectories")));
}

// A robot's whole map in its odom frame, every scan point where it was when measured, and beside it
// the trajectory.
void WriteMap(const simulation::Simulator& simulator, int robot, const std::string& stem) {
  const Pose T_odom_world = simulator.Truth(robot, 0).pose.Inverse();
  Cloud cloud;
  Trajectory trajectory;
  for (int i = 0; i < simulator.scan_count(); i += 5) {
    const StampedPose truth = simulator.Truth(robot, i);
    trajectory.push_back({truth.stamp_ns, T_odom_world * truth.pose});
    const double end_s =
        1e-9 * static_cast<double>(truth.stamp_ns - simulator.options().start_stamp_ns);
    const Scan scan = simulator.MakeScan(robot, i);
    for (size_t k = 0; k < scan.points.size(); k += 10) {
      const ScanPoint& p = scan.points[k];
      const Pose T_odom_sensor = T_odom_world * simulator.PoseAt(robot, end_s + p.time);
      const Eigen::Vector3f q = (T_odom_sensor * Eigen::Vector3d(p.x, p.y, p.z)).cast<float>();
      cloud.push_back({q.x(), q.y(), q.z(), p.intensity});
    }
  }
  ASSERT_TRUE(formats::WritePcd(stem + ".pcd", codec::MakePayload(cloud),
                                formats::PcdEncoding::kBinaryCompressed)
                  .ok());
  ASSERT_TRUE(formats::WriteTum(stem + ".tum", trajectory).ok());
}

Pose PoseOf(const json& pose) {
  const json &t = pose["translation"], &q = pose["rotation"];
  return Pose(Eigen::Quaterniond(q["w"], q["x"], q["y"], q["z"]),
              Eigen::Vector3d(t["x"], t["y"], t["z"]));
}

// Two robots' maps of a museum, with their trajectories beside them.
class MuseumMaps : public testing::Test {
 protected:
  void SetUp() override {
    const auto simulator = simulation::Simulator::Create(simulation::Options());  // Two robots.
    ASSERT_TRUE(simulator.ok()) << simulator.status();
    WriteMap(**simulator, 0, folder_ + "/alice");
    WriteMap(**simulator, 1, folder_ + "/bob");
    T_alice_bob_ = (*simulator)->Truth(0, 0).pose.Inverse() * (*simulator)->Truth(1, 0).pose;
  }

  ProgramResult Merge(const std::string& options = "") const {
    return Isthmus("merge " + folder_ + "/alice.pcd " + folder_ + "/bob.pcd -o " + folder_ +
                   "/merged.pcd --report " + folder_ + "/report.json " + options);
  }
  json Report() const { return json::parse(std::ifstream(folder_ + "/report.json")); }
  bool IsWritten() const { return std::filesystem::exists(folder_ + "/merged.pcd"); }
  void ExpectRight(const json& pair, double metres, double radians) const {
    const Pose error = T_alice_bob_.Inverse() * PoseOf(pair["t_a_b"]);
    EXPECT_LT(error.translation().norm(), metres);
    EXPECT_LT(RotationAngle(error), radians);
  }

  const std::string folder_ = ScratchFolder();
  Pose T_alice_bob_;
};

void ExpectNotBelieved(const json& report) {
  EXPECT_EQ(report["merged"], false);
  EXPECT_EQ(report["lacking"].size(), 2u);
  const json pair = report["pairs"][0];
  EXPECT_EQ(pair["reason"], "REASON_NO_POSES");
  EXPECT_EQ(pair["accepted"], false);
  EXPECT_EQ(pair["free_space"], -1) << "there is none that could be relied on";
  EXPECT_THAT(pair["detail"].get<std::string>(), HasSubstr("best alignment found"));
}

// One test: simulating the maps takes longer than merging them.
TEST_F(MuseumMaps, AreMergedWhereTheyBelongAndWithoutSensorPosesOnlyWhenAskedFor) {
  const ProgramResult merge = Merge("--trajectories " + folder_ + "/ways");
  ASSERT_EQ(merge.code, 0) << merge.out << merge.err;
  EXPECT_TRUE(std::filesystem::is_empty(folder_ + "/ways")) << "finished maps have none";
  EXPECT_TRUE(Report()["inputs"][0]["trajectory"].is_null());
  EXPECT_EQ(Report()["verified"], true);
  EXPECT_TRUE(Report()["lacking"].empty());
  EXPECT_EQ(Report()["pairs"][0]["accepted"], true);
  ExpectRight(Report()["pairs"][0], 0.15, 0.01);
  const auto merged = formats::ReadPcd(folder_ + "/merged.pcd");
  ASSERT_TRUE(merged.ok()) << merged.status();
  EXPECT_GT(merged->payload.width, 10'000u);

  std::filesystem::remove(folder_ + "/merged.pcd");
  std::filesystem::remove(folder_ + "/alice.tum");
  std::filesystem::remove(folder_ + "/bob.tum");
  const ProgramResult cautious = Merge();
  EXPECT_EQ(cautious.code, 3) << cautious.out << cautious.err;
  EXPECT_THAT(cautious.out, HasSubstr("bob.pcd: no sensor poses, so free space cannot be checked"));
  EXPECT_FALSE(IsWritten());
  ExpectNotBelieved(Report());

  const ProgramResult bold = Merge("--unverified");
  ASSERT_EQ(bold.code, 0) << bold.out << bold.err;
  EXPECT_THAT(bold.out, HasSubstr("UNVERIFIED: check it before you trust it"));
  EXPECT_TRUE(IsWritten());
  EXPECT_EQ(Report()["merged"], true);
  EXPECT_EQ(Report()["verified"], false);
  EXPECT_EQ(Report()["pairs"][0]["reason"], "REASON_UNVERIFIED");
  ExpectRight(Report()["pairs"][0], 0.3, 0.02);
  EXPECT_THAT(Report()["pairs"][0]["detail"].get<std::string>(), HasSubstr("% probable"));
}

}  // namespace
}  // namespace isthmus::cli
