#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/paper.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

using nlohmann::json;

TEST(Bench, PaperComparesTheOdometriesOnTheSameDrives) {
  if (!kHasPaper) GTEST_SKIP() << "built without A-LOAM";
  const std::string file = ScratchFolder() + "/paper.json";
  const ProgramResult bench = Isthmus(
      "bench paper --worlds museum --odometry aloam,floam --seed 2 --seconds 3 --report " + file);
  ASSERT_EQ(bench.code, 0) << bench.err;
  const json report = json::parse(std::ifstream(file));
  EXPECT_EQ(report["seconds"], 3);
  ASSERT_EQ(report["runs"].size(), 2u);
  double travelled_m = 0;
  for (const json& run : report["runs"]) {
    EXPECT_EQ(run["world"], "museum");
    EXPECT_EQ(run["seed"], 2);
    EXPECT_NE(bench.out.find(run["odometry"]), std::string::npos) << bench.out;
    EXPECT_GT(run["composition_ms"], 0);
    ASSERT_EQ(run["robots"].size(), 2u);
    for (const json& robot : run["robots"]) {
      EXPECT_EQ(robot["scans"], 30);
      EXPECT_EQ(robot["lost"], 0);
      EXPECT_EQ(robot["own"]["poses"], 30);
      EXPECT_LT(robot["own"]["rmse_m"], 0.05);
      EXPECT_GT(robot["odometry_ms_mean"], 0);
      EXPECT_GE(robot["odometry_ms_max"], robot["odometry_ms_mean"]);
    }
    if (travelled_m > 0) {
      EXPECT_NEAR(run["robots"][0]["travelled_m"], travelled_m, 0.05);
    }
    travelled_m = run["robots"][0]["travelled_m"];
  }
  EXPECT_EQ(report["runs"][0]["odometry"], "aloam");
  for (const char* table : {"Table 3. ", "Table 4. ", "Table 5. ", "MR-FLOAM  MR-ALOAM"}) {
    EXPECT_NE(bench.out.find(table), std::string::npos) << bench.out;
  }
  EXPECT_GT(report["runs"][0]["robots"][0]["matching_ms"], 0);
  EXPECT_EQ(report["runs"][1]["odometry"], "floam");
}

TEST(Bench, UnknownWorldsAndOdometriesAreNamed) {
  const ProgramResult world = Isthmus("bench paper --worlds atlantis --seconds 1");
  EXPECT_EQ(world.code, 2);
  EXPECT_NE(world.err.find("atlantis"), std::string::npos) << world.err;
  for (const char* seed : {"-1", "1,-1", "99999999999999999999"}) {
    EXPECT_EQ(Isthmus(std::string("bench paper --seconds 1 --seed ") + seed).code, 2) << seed;
  }
  const ProgramResult mode = Isthmus("bench paper --odometry magic --seconds 1");
  EXPECT_EQ(mode.code, 2);
  EXPECT_NE(mode.err.find("magic"), std::string::npos) << mode.err;
  EXPECT_EQ(Isthmus("bench").code, 2);
}

}  // namespace
}  // namespace isthmus::cli
