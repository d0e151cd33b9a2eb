#include "client/offline/merge/merge_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "client/offline/merge/viewpoints.h"
#include "core/codec/payload_builder.h"
#include "core/codec/payload_layout.h"
#include "core/formats/pcd.h"
#include "core/formats/tum.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

TEST(FinitePoints, LeavesOutWhatIsNotFiniteAndKeepsOrder) {
  const Cloud cloud{
      {1, 0, 0, 10}, {kNan, 0, 0, 20}, {3, 0, 0, 30}, {4, INFINITY, 0, 40}, {5, 0, 0, 50}};
  const auto points = FinitePoints(codec::MakePayload(cloud));
  ASSERT_TRUE(points.ok()) << points.status();
  ASSERT_EQ(points->size(), 3u);
  EXPECT_EQ((*points)[1].x, 3);
  EXPECT_EQ((*points)[2].intensity, 50);
}

TEST(FinitePoints, RefusesCloudsWithoutPoints) {
  EXPECT_TRUE(
      absl::IsInvalidArgument(FinitePoints(codec::MakePayload(Cloud{{kNan, 0, 0, 0}})).status()));
  PointPayload flat = codec::MakePayload(Cloud{{1, 2, 3, 4}});
  flat.fields.erase(flat.fields.begin() + 2);
  EXPECT_THAT(std::string(FinitePoints(flat).status().message()), HasSubstr("no field z"));
}

TEST(FinitePoints, NamesTheFilesPointThatIsTooFar) {
  const Cloud cloud{{kNan, 0, 0, 0}, {1, 0, 0, 0}, {2, 0, 0, 0}, {6000, 1, 0, 0}};
  EXPECT_THAT(std::string(FinitePoints(codec::MakePayload(cloud)).status().message()),
              HasSubstr("point 3, counted from 0, is at 6000.0 1.0 0.0"));
}

// As many as a map needs at least, of one place.
Cloud Heap() { return Cloud(100, {1, 2, 3, 4}); }

TEST(ReadMergeInputs, NamesRobotsAfterFilesAndKeepsTheViewpoint) {
  const std::string folder = ScratchFolder();
  std::filesystem::create_directories(folder + "/other");
  const Pose viewpoint(Eigen::Vector3d(1, 2, 3));
  const std::vector<std::string> files = {folder + "/first floor.pcd", folder + "/b.pcd",
                                          folder + "/other/b.pcd"};
  for (const std::string& file : files) {
    ASSERT_TRUE(
        formats::WritePcd(file, codec::MakePayload(Heap()), formats::PcdEncoding::kAscii, viewpoint)
            .ok());
  }
  std::set<std::string> names;
  const auto inputs = ReadMergeInputs(files, names);
  ASSERT_TRUE(inputs.ok()) << inputs.status();
  EXPECT_EQ((*inputs)[0].robot, "first_floor");
  EXPECT_EQ((*inputs)[1].robot, "b");
  EXPECT_EQ((*inputs)[2].robot, "b-2");
  const SubmapUpload& submap = (*inputs)[0].submaps.at(0);
  EXPECT_EQ((*inputs)[0].viewpoints, 1u);
  ASSERT_EQ(submap.keyframes.size(), 1u);
  EXPECT_TRUE(submap.keyframes[0].pose.translation().isApprox(viewpoint.translation()));
}

PointPayload FarCloud(double x, double y) {
  PointPayload cloud;
  cloud.width = 100;
  cloud.stride = 24;
  cloud.fields = {{"x", 0, ScalarType::kFloat64, 1},
                  {"y", 8, ScalarType::kFloat64, 1},
                  {"z", 16, ScalarType::kFloat64, 1}};
  for (int i = 0; i < 100; ++i) {
    const double values[] = {x + 0.001 * i, y, 20};
    cloud.data.append(reinterpret_cast<const char*>(values), sizeof(values));
  }
  return cloud;
}

TEST(ReadMergeInputs, MapsFarFromTheirOriginAreMovedNearItWithTheirViewpoints) {
  const std::string folder = ScratchFolder();
  const std::string viewed = folder + "/viewed.pcd", bare = folder + "/bare.pcd";
  const Pose viewpoint(Eigen::Vector3d(691'002, 5'334'002, 21));
  ASSERT_TRUE(formats::WritePcd(viewed, FarCloud(691'000.125, 5'334'000),
                                formats::PcdEncoding::kBinary, viewpoint)
                  .ok());
  ASSERT_TRUE(
      formats::WritePcd(bare, FarCloud(-6000, 0.5), formats::PcdEncoding::kBinary, Pose()).ok());
  std::set<std::string> names;
  const auto inputs = ReadMergeInputs({viewed, bare}, names);
  ASSERT_TRUE(inputs.ok()) << inputs.status();
  EXPECT_EQ(inputs->at(0).moved_by, Eigen::Vector3d(-691'000, -5'334'000, 0));
  EXPECT_EQ(inputs->at(1).moved_by, Eigen::Vector3d(5000, 0, 0)) << "of its middle";
  const SubmapUpload& submap = inputs->at(0).submaps.at(0);
  const auto x = codec::ReadColumn(submap.cloud, *codec::FindField(submap.cloud, {"x"}));
  EXPECT_NEAR(x[0], 0.125, 1e-6);
  EXPECT_NEAR(x[1], 0.126, 1e-6) << "moved before digits are lost";
  const Eigen::Vector3d seen_from = submap.keyframes.at(0).pose.translation();
  EXPECT_TRUE(seen_from.isApprox(Eigen::Vector3d(2, 2, 21))) << seen_from;
}

TEST(ReadMergeInputs, ATrajectoryBesideTheMapTellsWhatWasSeenFromWhere) {
  const std::string folder = ScratchFolder();
  // Points to the left and to the right of a wall that stands between the two viewpoints.
  Cloud cloud;
  for (int i = -10; i <= 10; ++i) {
    for (int k = -10; k <= 10; ++k) cloud.push_back({5, i * 0.1f, k * 0.1f, 0});
  }
  const size_t wall = cloud.size();
  for (int i = 0; i < 4; ++i) {
    cloud.push_back({3, 0.02f + 0.1f * (i % 2), 0.02f + 0.1f * (i / 2), 0});
    cloud.push_back({7, 0.52f + 0.1f * (i % 2), 0.02f + 0.1f * (i / 2), 0});
  }
  ASSERT_TRUE(
      formats::WritePcd(folder + "/a.pcd", codec::MakePayload(cloud), formats::PcdEncoding::kBinary)
          .ok());
  ASSERT_TRUE(formats::WriteTum(folder + "/a.tum", {{1, Pose()},
                                                    {2, Pose(Eigen::Vector3d(0.1, 0, 0))},
                                                    {3, Pose(Eigen::Vector3d(10, 0, 0))}})
                  .ok());
  std::set<std::string> names;
  const auto inputs = ReadMergeInputs({folder + "/a.pcd"}, names);
  ASSERT_TRUE(inputs.ok()) << inputs.status();
  EXPECT_EQ(inputs->at(0).viewpoints, 2u) << "the second pose is too near to the first";
  const SubmapUpload& submap = inputs->at(0).submaps.at(0);
  EXPECT_EQ(submap.last_stamp_ns, 3);
  const auto x = codec::ReadColumn(submap.cloud, *codec::FindField(submap.cloud, {"x"}));
  const auto keyframe =
      codec::ReadColumn(submap.cloud, *codec::FindField(submap.cloud, {"keyframe"}));
  size_t wall_points = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    if (x[i] == 3) {
      EXPECT_EQ(keyframe[i], 0);
    }
    if (x[i] == 7) {
      EXPECT_EQ(keyframe[i], 1);
    }
    wall_points += x[i] == 5;
  }
  EXPECT_EQ(std::count(x.begin(), x.end(), 3), 4);
  EXPECT_EQ(std::count(x.begin(), x.end(), 7), 4);
  EXPECT_GT(wall_points, wall * 3 / 2) << "most of the wall is seen from both sides";
}

// Reads `cloud` as a.pcd, with `trajectory` beside it unless it is empty.
absl::StatusOr<std::vector<MergeInput>> ReadOne(const Cloud& cloud, const Trajectory& trajectory,
                                                const Pose& viewpoint = {}) {
  const std::string folder = ScratchFolder(), map = folder + "/a.pcd";
  EXPECT_TRUE(
      formats::WritePcd(map, codec::MakePayload(cloud), formats::PcdEncoding::kBinary, viewpoint)
          .ok());
  if (!trajectory.empty()) {
    EXPECT_TRUE(formats::WriteTum(folder + "/a.tum", trajectory).ok());
  }
  std::set<std::string> names;
  return ReadMergeInputs({map}, names);
}

TEST(ReadMergeInputs, PosesAreSortedByTheirStampsWhichIsSaid) {
  Trajectory mixed;  // Every other of 40 poses first.
  for (int i = 0; i < 40; i += 2) mixed.push_back({i, Pose(Eigen::Vector3d(0.25 * i, 0, 0))});
  for (int i = 1; i < 40; i += 2) mixed.push_back({i, Pose(Eigen::Vector3d(0.25 * i, 0, 0))});
  const auto inputs = ReadOne(Heap(), mixed);
  ASSERT_TRUE(inputs.ok()) << inputs.status();
  EXPECT_EQ(inputs->at(0).viewpoints, 10u) << "a metre apart each";
  ASSERT_EQ(inputs->at(0).notes.size(), 1u);
  EXPECT_THAT(inputs->at(0).notes[0], HasSubstr("a.tum is not in order of time"));
}

TEST(ReadMergeInputs, PosesOfOneInstantStayInOrder) {
  const auto inputs = ReadOne(Heap(), {{7, Pose()}, {7, Pose(Eigen::Vector3d(5, 0, 0))}});
  ASSERT_TRUE(inputs.ok()) << inputs.status();
  EXPECT_EQ(inputs->at(0).viewpoints, 2u);
  EXPECT_TRUE(inputs->at(0).notes.empty());
}

TEST(ReadMergeInputs, PosesFromWhichNoPointIsSeenAreRefused) {
  const std::pair<double, std::string> kPlaces[] = {{101, "100 m"}, {500'001, "500000 m"}};
  for (const auto& [x, distance] : kPlaces) {
    const Pose far(Eigen::Vector3d(x, 2, 3));
    EXPECT_THAT(std::string(ReadOne(Heap(), {{1, far}}).status().message()),
                testing::AllOf(HasSubstr("a.tum does not fit "),
                               HasSubstr("its nearest pose is " + distance)));
    EXPECT_THAT(std::string(ReadOne(Heap(), {}, far).status().message()),
                testing::AllOf(HasSubstr("a.pcd: its VIEWPOINT is " + distance),
                               HasSubstr("a.tum, the robot's trajectory")));
  }
}

TEST(ReadMergeInputs, OnePoseFarOffMovesNoMap) {
  const auto inputs = ReadOne(Heap(), {{1, Pose(Eigen::Vector3d(500'000, 0, 0))}, {2, Pose()}});
  ASSERT_TRUE(inputs.ok()) << inputs.status();
  EXPECT_TRUE(inputs->at(0).moved_by.isZero());
}

TEST(ReadMergeInputs, FewPointsAreRefusedAndThoseLeftOutCounted) {
  EXPECT_THAT(std::string(ReadOne({{1, 2, 3, 4}}, {}).status().message()),
              HasSubstr("a.pcd: 1 point is too few to match"));
  Cloud cloud = Heap();
  cloud.insert(cloud.begin(), 2, {kNan, 0, 0, 0});
  const auto inputs = ReadOne(cloud, {});
  ASSERT_TRUE(inputs.ok()) << inputs.status();
  ASSERT_EQ(inputs->at(0).notes.size(), 1u);
  EXPECT_THAT(inputs->at(0).notes[0], HasSubstr("a.pcd: 2 of 102 points are left out"));
}

TEST(ReadMergeInputs, AMapWithALongWayBecomesSubmapsThatShareNoPoint) {
  const std::string folder = ScratchFolder();
  Cloud hall;
  for (int i = 0; i < 400; ++i) {
    for (int k = 0; k < 20; ++k) hall.push_back({i * 0.1f, 3, k * 0.1f, 0});
  }
  Trajectory way;
  for (int i = 0; i <= 400; ++i) {
    way.push_back({int64_t{i} * 10'000'000, Pose(Eigen::Vector3d(0.1 * i, 0, 1))});
  }
  ASSERT_TRUE(
      formats::WritePcd(folder + "/a.pcd", codec::MakePayload(hall), formats::PcdEncoding::kBinary)
          .ok());
  ASSERT_TRUE(formats::WriteTum(folder + "/a.tum", way).ok());
  std::set<std::string> names;
  const auto inputs = ReadMergeInputs({folder + "/a.pcd"}, names);
  ASSERT_TRUE(inputs.ok()) << inputs.status();
  std::vector<std::set<std::pair<double, double>>> seen;
  for (const SubmapUpload& submap : inputs->at(0).submaps) {
    const auto x = codec::ReadColumn(submap.cloud, *codec::FindField(submap.cloud, {"x"}));
    const auto z = codec::ReadColumn(submap.cloud, *codec::FindField(submap.cloud, {"z"}));
    seen.emplace_back();
    for (size_t i = 0; i < x.size(); ++i) seen.back().emplace(x[i], z[i]);
  }
  ASSERT_EQ(seen.size(), 3u) << "40 m are two submaps of 15 m and a rest";
  std::set<std::pair<double, double>> all;
  size_t sum = 0;
  for (const auto& points : seen) {
    all.insert(points.begin(), points.end());
    sum += points.size();
  }
  EXPECT_EQ(sum, hall.size());
  EXPECT_EQ(all.size(), hall.size());
  const auto is_in_the_middle = [](const auto& p) { return p.first > 14 && p.first < 16; };
  EXPECT_GT(std::ranges::count_if(seen[0], is_in_the_middle), 100) << "to each in turn";
  EXPECT_GT(std::ranges::count_if(seen[1], is_in_the_middle), 100) << "to each in turn";
}

// A wall at 4 m, of points 4 cm apart.
Cloud DenseWall() {
  Cloud cloud;
  for (int i = -60; i <= 60; ++i) {
    for (int k = -60; k <= 60; ++k) cloud.push_back({4, i * 0.04f, k * 0.04f, 0});
  }
  return cloud;
}

// Points of a round patch of 0.3 m at 0.7 m.
void AddPatch(int points, Cloud& cloud) {
  for (int i = 0; i < points; ++i) {
    const float angle = 0.7f * static_cast<float>(i);
    const float radius = 0.3f * std::sqrt(static_cast<float>(i) / static_cast<float>(points));
    cloud.push_back({0.7f, radius * std::cos(angle), radius * std::sin(angle), 0});
  }
}

const Trajectory kBeforeTheWall = {{0, Pose()}, {1, Pose(Eigen::Vector3d(0, 0.5, 0))}};

TEST(VisiblePoints, PointsOfADenseMapHideLittle) {
  Cloud cloud = DenseWall();
  const size_t wall = cloud.size();
  AddPatch(300, cloud);
  const auto visible = VisiblePoints(cloud, kBeforeTheWall);
  for (const size_t k : {0, 2}) {
    EXPECT_GT(std::ranges::count_if(visible[k], [&](uint32_t i) { return i < wall; }), wall / 4);
  }
}

TEST(VisiblePoints, DustHidesNothingAndIsInSightOfNone) {
  Cloud cloud = DenseWall();
  const auto without = VisiblePoints(cloud, kBeforeTheWall);
  const size_t wall = cloud.size();
  AddPatch(12, cloud);
  const auto with = VisiblePoints(cloud, kBeforeTheWall);
  EXPECT_EQ(with[0], without[0]);
  EXPECT_EQ(with[2], without[2]);
  size_t dust = 0;
  for (const size_t k : {1, 3}) {
    dust += std::ranges::count_if(with[k], [&](uint32_t i) { return i >= wall; });
  }
  EXPECT_EQ(dust, 12u) << "and is kept";
}

TEST(VisiblePoints, HiddenPointsAreInSightOfNoneAndKept) {
  Cloud cloud = DenseWall();
  const size_t wall = cloud.size();
  for (size_t i = 0; i < wall; ++i) {
    const Point& p = cloud[i];
    if (std::abs(p.y) < 1 && std::abs(p.z) < 1) cloud.push_back({6, p.y, p.z, 0});
  }
  const auto visible = VisiblePoints(cloud, kBeforeTheWall);
  size_t hidden = 0;
  for (size_t k = 0; k < visible.size(); ++k) {
    const auto behind = std::ranges::count_if(visible[k], [&](uint32_t i) { return i >= wall; });
    if (k % 2 == 0) {
      EXPECT_EQ(behind, 0);
    }
    hidden += behind;
  }
  EXPECT_EQ(hidden, cloud.size() - wall);
}

}  // namespace
}  // namespace isthmus::cli
