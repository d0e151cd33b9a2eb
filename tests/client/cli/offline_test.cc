// The commands that bring their own server.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/codec/payload_builder.h"
#include "core/codec/pcd.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

using nlohmann::json;

TEST(Offline, SimulateOdometryAndEvalFitTogether) {
  const std::string folder = ScratchFolder();
  ASSERT_EQ(Isthmus("simulate --world museum --robots 1 --seconds 4 -o " + folder).code, 0);
  const ProgramResult odometry = Isthmus("odometry " + folder + "/robot_0 -o " + folder +
                                         "/odom.tum --timing " + folder + "/timing.csv --json");
  ASSERT_EQ(odometry.code, 0) << odometry.err;
  EXPECT_EQ(json::parse(odometry.out)["poses"], 40);

  std::ifstream timing(folder + "/timing.csv");
  std::string line;
  std::getline(timing, line);
  EXPECT_EQ(line, "scan,features_ms,matching_ms,map_ms,total_ms");
  int rows = 0;
  while (std::getline(timing, line)) {
    double scan = -1, features = 0, matching = 0, map = 0, total = 0;
    ASSERT_EQ(
        std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf", &scan, &features, &matching, &map, &total),
        5);
    EXPECT_EQ(scan, rows++);
    EXPECT_GT(total, 0);
  }
  EXPECT_EQ(rows, 40);

  const ProgramResult eval = Isthmus("eval --truth " + folder + "/robot_0.truth.tum --estimate " +
                                     folder + "/odom.tum --json");
  ASSERT_EQ(eval.code, 0) << eval.err;
  const json robot = json::parse(eval.out)["robots"][0];
  EXPECT_EQ(robot["poses"], 40);
  EXPECT_LT(robot["rmse_m"], 0.10);
}

// A wall of 4 m and nothing else: no two maps can be told to belong together by it.
std::string WriteWall(const std::string& path, float y) {
  Cloud cloud;
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 20; ++k) cloud.push_back({i * 0.02f, y, k * 0.1f, 1});
  }
  EXPECT_TRUE(
      codec::WritePcd(path, codec::MakePayload(cloud), codec::PcdEncoding::kBinaryCompressed).ok());
  return path;
}

TEST(Offline, MapsWithoutEvidenceAreNotMergedAndTheReportSaysWhy) {
  const std::string folder = ScratchFolder();
  const ProgramResult merge =
      Isthmus("merge " + WriteWall(folder + "/a.pcd", 2) + " " + WriteWall(folder + "/b.pcd", -3) +
              " -o " + folder + "/merged.pcd --json " + folder + "/report.json");
  EXPECT_EQ(merge.code, 3) << merge.out << merge.err;
  const json report = json::parse(std::ifstream(folder + "/report.json"));
  EXPECT_EQ(report["merged"], false);
  EXPECT_TRUE(report["file"].is_null());
  ASSERT_EQ(report["pairs"].size(), 1u);
  EXPECT_EQ(report["pairs"][0]["accepted"], false);
  EXPECT_NE(report["pairs"][0]["detail"], "");
  EXPECT_FALSE(std::ifstream(folder + "/merged.pcd").good());
}

}  // namespace
}  // namespace isthmus::cli
