#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
