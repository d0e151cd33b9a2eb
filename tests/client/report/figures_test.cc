#include "client/report/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "client/report/evaluation_figures.h"
#include "client/report/evaluation_page.h"
#include "client/report/limits.h"
#include "client/report/server_page.h"
#include "core/io/file_io.h"
#include "tests/client/report/server_states.h"

namespace isthmus::report {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr char kEvilName[] = "_<script>$x_1$";

class FiguresTest : public testing::Test {
 protected:
  FiguresTest() { fs::remove_all(folder_); }
  ~FiguresTest() override { fs::remove_all(folder_); }

  std::string Read(const std::string& name) const {
    return io::ReadFile(folder_ + "/" + name).value_or("");
  }
  // Width and height by the file's head.
  std::pair<unsigned, unsigned> PngSize(const std::string& name) const {
    const std::string png = Read(name);
    if (png.size() < 24 || png.substr(1, 3) != "PNG") return {0, 0};
    const auto number = [&](size_t at) {
      unsigned value = 0;
      for (size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<unsigned char>(png[i]);
      return value;
    };
    return {number(16), number(20)};
  }

  const std::string folder_ =
      testing::TempDir() + "isthmus_figures_test_" + std::to_string(getpid());
};

evaluation::Evaluation SomeEvaluation() {
  Trajectory truth, estimate;
  for (int i = 0; i < 200; ++i) {
    const Pose pose =
        Pose::FromXyzRpy(10 * std::cos(0.02 * i), 6 * std::sin(0.02 * i), 0, 0, 0, 0.02 * i);
    truth.push_back({i * int64_t{100'000'000}, pose});
    estimate.push_back(
        {truth.back().stamp_ns, Pose(Eigen::Vector3d(0, 0.05 * std::sin(i), 0)) * pose});
  }
  return *evaluation::Evaluate({{kEvilName, truth, estimate}, {"bob", truth, truth}});
}

TEST_F(FiguresTest, OfAnEvaluationAreFilesOfTheRightKindAndSize) {
  if (!ISTHMUS_HAS_MATPLOTLIB) GTEST_SKIP() << "install python3-matplotlib";
  TimingFile timing{"t", {0, 1}, {{"features", {1, 2}}}, {1, 2}, {"ok", "lost"}};
  const auto evaluation = SomeEvaluation();
  const auto figures = FiguresOf(evaluation, false, {timing});
  ASSERT_EQ(figures.size(), 4u);
  const absl::Status drawn = DrawFigures(folder_, figures);
  ASSERT_TRUE(drawn.ok()) << drawn;
  for (const Figure& figure : figures) {
    const std::string file = figure["file"];
    const auto [width, height] = PngSize(file + ".png");
    EXPECT_NEAR(width, 1200, 150) << file << ": 8 inches at 150 dots";
    EXPECT_GT(height, 250u) << file;
    EXPECT_THAT(Read(file + ".svg"), HasSubstr("<svg ")) << file;
    EXPECT_THAT(Read(file + ".svg"), Not(HasSubstr("<script"))) << file;
  }
  EXPECT_THAT(Read("trajectories.svg"), HasSubstr("&lt;script&gt;$x_1$"));
  EXPECT_TRUE(fs::exists(folder_ + "/figures.py") && fs::exists(folder_ + "/figures.json"));
  EXPECT_FALSE(fs::exists(folder_ + "/figures.log"));

  const auto page = EvaluationPage(evaluation, figures, folder_);
  ASSERT_TRUE(page.ok()) << page.status();
  EXPECT_THAT(*page, Not(HasSubstr("<script")));
  EXPECT_THAT(*page, Not(HasSubstr("<?xml")));
  EXPECT_THAT(*page, HasSubstr("id=\"rpe-"));
  EXPECT_THAT(*page, HasSubstr("currentColor"));
}

TEST_F(FiguresTest, OfAServerAreItsMapAndGraph) {
  if (!ISTHMUS_HAS_MATPLOTLIB) GTEST_SKIP() << "install python3-matplotlib";
  ServerState state = TwoApart(MatchReason::kLowOverlap, kEvilName);
  ComponentMap map;
  map.robots = {RobotId(kEvilName), RobotId("bob")};
  for (int i = 0; i < 100; ++i) map.points.push_back({0.1f * i, 0.05f * i, 0.02f * i, 0, 0});
  map.ways = {{{0, Pose()}, {1, Pose(Eigen::Vector3d(10, 5, 0))}}, {}};
  state.maps = {map};
  const auto figures = FiguresOf(state, folder_);
  ASSERT_TRUE(figures.ok()) << figures.status();
  ASSERT_EQ(figures->size(), 2u);
  EXPECT_EQ((*figures)[0]["series"].size(), 1u) << "bob is in another map";
  const absl::Status drawn = DrawFigures(folder_, *figures);
  ASSERT_TRUE(drawn.ok()) << drawn;
  EXPECT_GT(PngSize("map_0.png").first, 800u);
  EXPECT_GT(PngSize("match_graph.png").first, 800u);
  const auto page = ServerPage(state, *figures, folder_);
  ASSERT_TRUE(page.ok()) << page.status();
  EXPECT_THAT(*page, HasSubstr("LOW_OVERLAP"));
  EXPECT_THAT(*page, HasSubstr("data:image/png;base64"));
  EXPECT_THAT(*page, Not(HasSubstr("<script")));
}

TEST_F(FiguresTest, WithoutPythonThePackageIsNamed) {
  setenv("ISTHMUS_PYTHON", "/no/such/python", 1);
  const absl::Status drawn = DrawFigures(folder_, {});
  unsetenv("ISTHMUS_PYTHON");
  EXPECT_EQ(drawn.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(drawn.message()), HasSubstr("apt-get install python3-matplotlib"));
}

TEST_F(FiguresTest, WhatPythonSaysIsToldWhereItFails) {
  if (!ISTHMUS_HAS_MATPLOTLIB) GTEST_SKIP() << "install python3-matplotlib";
  const absl::Status drawn = DrawFigures(folder_, {{{"file", "x"}, {"kind", "no_such"}}});
  EXPECT_EQ(drawn.code(), absl::StatusCode::kInternal);
  EXPECT_THAT(std::string(drawn.message()), HasSubstr("draw_no_such"));
}

TEST(Thinned, KeepsTheEnds) {
  std::vector<double> values(10007);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i);
  const auto thinned = Thinned(values, kFigurePoints);
  EXPECT_LE(thinned.size(), kFigurePoints + 1);
  EXPECT_EQ(thinned.front(), 0);
  EXPECT_EQ(thinned.back(), 10006);
  EXPECT_EQ(Thinned({1, 2, 3}, 3), (std::vector<double>{1, 2, 3}));
}

}  // namespace
}  // namespace isthmus::report
