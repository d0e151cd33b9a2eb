#include "client/cli/merge_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/codec/payload_builder.h"
#include "core/codec/payload_layout.h"
#include "core/codec/pcd.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<double> Column(const PointPayload& payload, const char* field) {
  return codec::ReadColumn(payload, *codec::FindField(payload, {field}));
}

TEST(SplitFinite, LeavesOutWhatIsNotFiniteAndKeepsOrder) {
  const Cloud cloud{
      {1, 0, 0, 10}, {kNan, 0, 0, 20}, {3, 0, 0, 30}, {4, INFINITY, 0, 40}, {5, 0, 0, 50}};
  const auto parts = SplitFinite(codec::MakePayload(cloud), 2);
  ASSERT_TRUE(parts.ok()) << parts.status();
  ASSERT_EQ(parts->size(), 2u);
  EXPECT_THAT(Column((*parts)[0], "x"), ElementsAre(1, 3));
  EXPECT_THAT(Column((*parts)[0], "intensity"), ElementsAre(10, 30));
  EXPECT_THAT(Column((*parts)[1], "x"), ElementsAre(5));
}

TEST(SplitFinite, RefusesCloudsWithoutPoints) {
  EXPECT_TRUE(absl::IsInvalidArgument(
      SplitFinite(codec::MakePayload(Cloud{{kNan, 0, 0, 0}}), 10).status()));
  PointPayload flat = codec::MakePayload(Cloud{{1, 2, 3, 4}});
  flat.fields.erase(flat.fields.begin() + 2);
  EXPECT_THAT(std::string(SplitFinite(flat, 10).status().message()), HasSubstr("no field z"));
}

TEST(ReadMergeInputs, NamesRobotsAfterFilesAndKeepsTheViewpoint) {
  const std::string folder = ScratchFolder();
  std::filesystem::create_directories(folder + "/other");
  const Pose viewpoint(Eigen::Vector3d(1, 2, 3));
  const std::vector<std::string> files = {folder + "/first floor.pcd", folder + "/b.pcd",
                                          folder + "/other/b.pcd"};
  for (const std::string& file : files) {
    ASSERT_TRUE(codec::WritePcd(file, codec::MakePayload(Cloud{{1, 2, 3, 4}}),
                                codec::PcdEncoding::kAscii, viewpoint)
                    .ok());
  }
  const auto inputs = ReadMergeInputs(files);
  ASSERT_TRUE(inputs.ok()) << inputs.status();
  EXPECT_EQ((*inputs)[0].robot, "first_floor");
  EXPECT_EQ((*inputs)[1].robot, "b");
  EXPECT_EQ((*inputs)[2].robot, "b-2");
  const client::SubmapUpload& submap = (*inputs)[0].submaps.at(0);
  ASSERT_EQ(submap.keyframes.size(), 1u);
  EXPECT_TRUE(submap.keyframes[0].pose.translation().isApprox(viewpoint.translation()));
}

}  // namespace
}  // namespace isthmus::cli
