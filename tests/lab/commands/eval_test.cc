#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

using testing::HasSubstr;

class EvalTest : public testing::Test {
 protected:
  // Ten poses along x, `side` metres to the left; odd ones `noise` further to the left and even
  // ones to the right.
  std::string Tum(const std::string& name, double side, double noise) const {
    std::ofstream file(folder_ + "/" + name);
    for (int i = 0; i < 10; ++i) {
      file << 100 + 0.1 * i << " " << i << " " << side + (i % 2 == 0 ? -noise : noise)
           << " 0 0 0 0 1\n";
    }
    return folder_ + "/" + name;
  }

  const std::string folder_ = ScratchFolder();
};

TEST_F(EvalTest, PrintsRmseByEquationThree) {
  const std::string truth = Tum("truth.tum", 0, 0), estimate = Tum("estimate.tum", 0, 0.5);
  const ProgramResult result =
      Isthmus("eval --truth " + truth + " --estimate " + estimate + " --align none --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto report = nlohmann::json::parse(result.out);
  EXPECT_NEAR(report["robots"][0]["rmse_m"].get<double>(), 0.5, 1e-9);
  EXPECT_EQ(report["robots"][0]["poses"], 10);
  EXPECT_TRUE(report["merged"].is_null());
}

TEST_F(EvalTest, ARobotInTheWrongPlaceCountsOnlyWhenMerged) {
  const std::string files = "--truth " + Tum("a_truth.tum", 0, 0) + " " + Tum("b_truth.tum", 5, 0) +
                            " --estimate " + Tum("a.tum", 0, 0) + " " + Tum("b.tum", 7, 0);
  const auto alone = nlohmann::json::parse(Isthmus("eval --json " + files).out);
  EXPECT_NEAR(alone["robots"][1]["rmse_m"].get<double>(), 0, 1e-6);
  const auto merged = nlohmann::json::parse(Isthmus("eval --merged --json " + files).out);
  // The best common alignment puts both 1 m off.
  EXPECT_NEAR(merged["merged"]["rmse_m"].get<double>(), 1, 1e-6);
}

TEST_F(EvalTest, SaysHowPosesWerePairedAndAligned) {
  const std::string truth = Tum("truth.tum", 0, 0), estimate = Tum("estimate.tum", 0, 0.5);
  const ProgramResult text = Isthmus("eval --truth " + truth + " --estimate " + estimate);
  ASSERT_EQ(text.code, 0) << text.err;
  for (const char* said : {"at most 0.02 s apart: estimate 10 of 10", "no scale", "9.0 m",
                           "too short for KITTI's segments", "Absolute trajectory error"}) {
    EXPECT_THAT(text.out, HasSubstr(said));
  }
  EXPECT_THAT(Isthmus("eval --align first --truth " + truth + " --estimate " + estimate).out,
              HasSubstr("the first pair of poses is made to coincide"));
}

TEST_F(EvalTest, EveryFormatHasTheSameNumbers) {
  const std::string files = "--align none --truth " + Tum("truth.tum", 0, 0) + " --estimate " +
                            Tum("estimate.tum", 0, 0.5);
  const auto report = nlohmann::json::parse(Isthmus("eval --format json " + files).out);
  EXPECT_EQ(report, nlohmann::json::parse(Isthmus("eval --json " + files).out));
  const auto& robot = report["robots"][0];
  EXPECT_NEAR(robot["std_m"].get<double>(), 0, 1e-9);
  EXPECT_NEAR(robot["per_frame"]["translation_m"]["rmse"].get<double>(), 1, 1e-9);
  EXPECT_EQ(robot["segments"]["kitti"], false);
  EXPECT_EQ(robot["estimate_poses"], 10);
  EXPECT_THAT(Isthmus("eval --format text " + files).out, HasSubstr("0.5000"));
  EXPECT_THAT(Isthmus("eval --format markdown " + files).out,
              HasSubstr("| estimate | 10 | 0.5000 |"));
  const std::string latex = Isthmus("eval --format latex " + files).out;
  EXPECT_THAT(latex, HasSubstr("estimate & 10 & 0.5000 &"));
  EXPECT_EQ(Isthmus("eval --format html " + files).code, 2);
}

TEST_F(EvalTest, KittiFilesAreReadWithTheirTimes) {
  const std::string truth = Tum("truth.tum", 0, 0), kitti = folder_ + "/00.txt";
  std::ofstream poses(kitti), times(folder_ + "/times.txt");
  for (int i = 0; i < 10; ++i) {
    poses << "1 0 0 " << i << " 0 1 0 0.25 0 0 1 0\n";
    times << 100 + 0.1 * i << "\n";
  }
  poses.close();
  times.close();
  const std::string files = "--align none --json --truth " + truth + " --estimate " + kitti;
  const auto report =
      nlohmann::json::parse(Isthmus("eval " + files + " --times " + folder_ + "/times.txt").out);
  EXPECT_NEAR(report["robots"][0]["rmse_m"].get<double>(), 0.25, 1e-9);
  const ProgramResult without = Isthmus("eval " + files);
  EXPECT_EQ(without.code, 5);
  EXPECT_THAT(without.err, HasSubstr("--times"));
  const auto lines =
      nlohmann::json::parse(Isthmus("eval --json --truth " + kitti + " --estimate " + kitti).out);
  EXPECT_EQ(lines["robots"][0]["poses"], 10) << "two KITTI files, line by line";
}

TEST_F(EvalTest, OneTruthServesSeveralEstimates) {
  const std::string truth = Tum("truth.tum", 0, 0);
  const auto report =
      nlohmann::json::parse(Isthmus("eval --json --truth " + truth + " --estimate " + truth + " " +
                                    Tum("b.tum", 0, 0.5) + " --names mine yours")
                                .out);
  ASSERT_EQ(report["robots"].size(), 2u);
  EXPECT_EQ(report["robots"][1]["name"], "yours");
}

TEST_F(EvalTest, WithoutMatplotlibTheTablesComeAndThePackageIsNamed) {
  const std::string truth = Tum("truth.tum", 0, 0);
  setenv("ISTHMUS_PYTHON", "/no/such/python", 1);
  const ProgramResult result =
      Isthmus("eval --truth " + truth + " --estimate " + truth + " --figures " + folder_ + "/f");
  unsetenv("ISTHMUS_PYTHON");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("python3-matplotlib"));
  EXPECT_THAT(result.out, HasSubstr("Absolute trajectory error"));
}

TEST_F(EvalTest, SaysWhatIsWrong) {
  const std::string truth = Tum("truth.tum", 0, 0);
  const ProgramResult counts =
      Isthmus("eval --truth " + truth + " " + truth + " --estimate " + truth);
  EXPECT_EQ(counts.code, 2);
  EXPECT_THAT(counts.err, HasSubstr("one truth per estimate"));
  const ProgramResult missing = Isthmus("eval --truth " + truth + " --estimate none.tum");
  EXPECT_EQ(missing.code, 5);
  EXPECT_THAT(missing.err, HasSubstr("none.tum"));
  std::ofstream(folder_ + "/torn.tum") << "100 1 2 3\n";
  EXPECT_EQ(Isthmus("eval --truth " + truth + " --estimate " + folder_ + "/torn.tum").code, 5);
}

}  // namespace
}  // namespace isthmus::cli
