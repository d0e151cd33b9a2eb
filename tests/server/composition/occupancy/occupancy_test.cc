#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "server/composition/occupancy/kept_occupancy.h"
#include "tests/server/composition/test_maps.h"

namespace isthmus::composition {
namespace {

// A wall at x = 5 seen from the origin, 4 m wide and 2 m high.
std::vector<SubmapPoint> Wall() {
  std::vector<SubmapPoint> points;
  for (double y = -2; y <= 2; y += 0.05) {
    for (double z = -1; z <= 1; z += 0.05) points.push_back(At(5.05, y, z));
  }
  return points;
}

std::unique_ptr<octomap::OcTree> ReadTree(const std::string& file, OccupancyFormat format) {
  std::istringstream stream(file);
  if (format == OccupancyFormat::kFull) {
    return std::unique_ptr<octomap::OcTree>(
        dynamic_cast<octomap::OcTree*>(octomap::AbstractOcTree::read(stream)));
  }
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  return tree->readBinary(stream) ? std::move(tree) : nullptr;
}

absl::StatusOr<std::string> WriteFile(const std::vector<LaidSubmap>& submaps, uint32_t component,
                                      OccupancyFormat format, const OccupancyOptions& options) {
  return WriteOccupancy(Placed(submaps), ReaderOf(submaps), component, format, options);
}

enum class State { kUnknown, kFree, kOccupied };

State StateAt(const octomap::OcTree& tree, double x, double y, double z) {
  const octomap::OcTreeNode* node = tree.search(x, y, z);
  if (!node) return State::kUnknown;
  return tree.isNodeOccupied(node) ? State::kOccupied : State::kFree;
}

class Occupancy : public ::testing::TestWithParam<OccupancyFormat> {
 protected:
  std::unique_ptr<octomap::OcTree> Write(const std::vector<LaidSubmap>& submaps,
                                         const OccupancyOptions& options = {},
                                         uint32_t component = 0) {
    const auto file = WriteFile(submaps, component, GetParam(), options);
    EXPECT_TRUE(file.ok()) << file.status();
    return file.ok() ? ReadTree(*file, GetParam()) : nullptr;
  }
};

INSTANTIATE_TEST_SUITE_P(Formats, Occupancy,
                         ::testing::Values(OccupancyFormat::kBinary, OccupancyFormat::kFull),
                         [](const auto& format) {
                           return format.param == OccupancyFormat::kBinary ? "bt" : "ot";
                         });

TEST_P(Occupancy, WallIsOccupiedBeforeItFreeBehindItUnknown) {
  const auto tree = Write({MakeSubmap("alice", 0, Wall())}, {.resolution_m = 0.1});
  ASSERT_NE(tree, nullptr);
  EXPECT_DOUBLE_EQ(tree->getResolution(), 0.1);
  for (const double y : {-1.5, 0.03, 1.5}) {
    EXPECT_EQ(StateAt(*tree, 5.05, y, 0.02), State::kOccupied) << y;
    EXPECT_EQ(StateAt(*tree, 2.5, y / 2, 0.02), State::kFree) << y;
    EXPECT_EQ(StateAt(*tree, 5.5, y * 1.1, 0.02), State::kUnknown) << y;
  }
  EXPECT_EQ(StateAt(*tree, -1, 0, 0), State::kUnknown);
}

TEST_P(Occupancy, RaysStartAtTheKeyframeThatSaw) {
  Submap submap;
  submap.id = {SessionId("alice-1"), 0};
  submap.keyframes.resize(2);
  submap.keyframes[1].T_submap_sensor = Pose(Eigen::Vector3d(0, 4, 0));
  submap.points = {At(3, 0.05, 0), At(3, 4.05, 0)};
  submap.points[1].keyframe = 1;
  const Pose T_map_submap = Pose(Eigen::Vector3d(100, 0, 1));
  const auto tree = Write({{std::make_shared<Submap>(submap), 0, T_map_submap}});
  ASSERT_NE(tree, nullptr);
  EXPECT_EQ(StateAt(*tree, 103, 0.05, 1.05), State::kOccupied);
  EXPECT_EQ(StateAt(*tree, 103, 4.05, 1.05), State::kOccupied);
  EXPECT_EQ(StateAt(*tree, 101, 0.05, 1.05), State::kFree);
  EXPECT_EQ(StateAt(*tree, 101, 4.05, 1.05), State::kFree);
  EXPECT_EQ(StateAt(*tree, 101.5, 2.05, 1.05), State::kUnknown);  // Between the two rays.
}

TEST_P(Occupancy, RaysAreCutAtTheRange) {
  const auto tree = Write({MakeSubmap("alice", 0, {At(20, 0.05, 0.05)})},
                          {.resolution_m = 0.2, .max_range_m = 10});
  ASSERT_NE(tree, nullptr);
  EXPECT_EQ(StateAt(*tree, 9.5, 0.05, 0.05), State::kFree);
  EXPECT_EQ(StateAt(*tree, 10.5, 0.05, 0.05), State::kUnknown);
  EXPECT_EQ(StateAt(*tree, 20, 0.05, 0.05), State::kUnknown);
}

TEST_P(Occupancy, WhatWentAwayBecomesFree) {
  std::vector<LaidSubmap> submaps{MakeSubmap("alice", 0, {At(3.05, 0.05, 0.05)})};
  ASSERT_EQ(StateAt(*Write(submaps), 3.05, 0.05, 0.05), State::kOccupied);
  for (uint32_t look = 1; look <= 5; ++look) {
    submaps.push_back(MakeSubmap("bob", look, {At(6.05, 0.1, 0.1)}));
  }
  const auto tree = Write(submaps);
  EXPECT_EQ(StateAt(*tree, 3.05, 0.05, 0.05), State::kFree);
  EXPECT_EQ(StateAt(*tree, 6.05, 0.1, 0.1), State::kOccupied);
}

TEST_P(Occupancy, OnlyTheComponentAskedFor) {
  const std::vector<LaidSubmap> submaps{MakeSubmap("alice", 0, {At(3, 0.05, 0.05)}),
                                        MakeSubmap("bob", 0, {At(-3, 0.05, 0.05)}, Pose(), 1)};
  const auto tree = Write(submaps, {}, 1);
  EXPECT_EQ(StateAt(*tree, 3, 0.05, 0.05), State::kUnknown);
  EXPECT_EQ(StateAt(*tree, -3, 0.05, 0.05), State::kOccupied);
  const auto empty = Write(submaps, {}, 2);
  ASSERT_NE(empty, nullptr);
  EXPECT_EQ(empty->size(), 0u);
}

TEST_P(Occupancy, UnusablePointsAreLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  auto points = Wall();
  points.push_back(At(nan, 0, 0));
  points.push_back(At(0, std::numeric_limits<double>::infinity(), 0));
  points.push_back(At(1, 1, 1));
  points.back().keyframe = 9;  // There is no such keyframe.
  const auto tree = Write({MakeSubmap("alice", 0, points), LaidSubmap{}});
  ASSERT_NE(tree, nullptr);
  EXPECT_EQ(tree->size(), Write({MakeSubmap("alice", 0, Wall())})->size());
}

TEST_P(Occupancy, ARegionKeepsWhatLiesInItAsItIs) {
  Region region;
  region.box.min = {2, -1, -0.5};
  region.box.max = {5.2, 1, 0.5};
  const auto tree =
      Write({MakeSubmap("alice", 0, Wall())}, {.resolution_m = 0.1, .region = region});
  ASSERT_NE(tree, nullptr);
  EXPECT_EQ(StateAt(*tree, 5.05, 0.03, 0.02), State::kOccupied);
  EXPECT_EQ(StateAt(*tree, 2.5, 0.03, 0.02), State::kFree);
  EXPECT_EQ(StateAt(*tree, 1.5, 0.03, 0.02), State::kUnknown) << "outside";
  EXPECT_EQ(StateAt(*tree, 5.05, 1.5, 0.02), State::kUnknown);
  region.box = Box();
  region.has_sphere = true;
  region.center = {5, 0, 0};
  region.radius_m = 1;
  const auto round =
      Write({MakeSubmap("alice", 0, Wall())}, {.resolution_m = 0.1, .region = region});
  EXPECT_EQ(StateAt(*round, 5.05, 0.03, 0.02), State::kOccupied);
  EXPECT_EQ(StateAt(*round, 3.5, 0.03, 0.02), State::kUnknown);
  // A hit outside still clears its way through.
  region.center = {2.5, 0, 0};
  const auto before =
      Write({MakeSubmap("alice", 0, Wall())}, {.resolution_m = 0.1, .region = region});
  EXPECT_EQ(StateAt(*before, 2.5, 0.03, 0.02), State::kFree);
}

TEST_P(Occupancy, WhatCannotBeReadIsLeftOutAndCounted) {
  const std::vector<LaidSubmap> there{MakeSubmap("alice", 0, Wall())};
  auto all = there;
  all.push_back(MakeSubmap("bob", 0, {At(-3, 0.05, 0.05)}));
  all.push_back(MakeSubmap("carol", 0, {At(-3, 0.05, 0.05)}, Pose(), 1));  // Is not asked for.
  uint64_t missing = 7;
  const auto file = WriteOccupancy(Placed(all), ReaderOf(there), 0, GetParam(), {}, &missing);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(missing, 1u);
  EXPECT_EQ(*file, *WriteOccupancy(Placed(there), ReaderOf(there), 0, GetParam(), {}, &missing));
  EXPECT_EQ(missing, 0u);
}

// A server's log is no place for a library's progress.
TEST_P(Occupancy, PrintsNothing) {
  ::testing::internal::CaptureStderr();
  ::testing::internal::CaptureStdout();
  const auto file = WriteFile({MakeSubmap("alice", 0, Wall())}, 0, GetParam(), {});
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_TRUE(file.ok());
}

TEST(OccupancyLimits, OptionsAreChecked) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const OccupancyOptions& options :
       {OccupancyOptions{.resolution_m = 0}, OccupancyOptions{.resolution_m = nan},
        OccupancyOptions{.resolution_m = -1}, OccupancyOptions{.resolution_m = 100},
        OccupancyOptions{.max_range_m = 0}, OccupancyOptions{.max_range_m = nan},
        OccupancyOptions{.max_range_m = 1e9}}) {
    EXPECT_EQ(WriteFile({}, 0, OccupancyFormat::kBinary, options).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
}

TEST(OccupancyLimits, MapFartherThanTheFormatReaches) {
  const auto far = MakeSubmap("alice", 0, {At(3, 0, 0)}, Pose(Eigen::Vector3d(7000, 0, 0)));
  EXPECT_EQ(WriteFile({far}, 0, OccupancyFormat::kBinary, {}).status().code(),
            absl::StatusCode::kOutOfRange);
  EXPECT_TRUE(WriteFile({far}, 0, OccupancyFormat::kBinary, {.resolution_m = 0.5}).ok());
}

TEST(OccupancyLimits, MemoryIsBounded) {
  std::mt19937 rng(3);
  const auto wide =
      MakeSubmap("alice", 0, RandomPoints(&rng, 20000, MakeBox({-90, -90, -90}, {90, 90, 90})));
  const auto file = WriteFile({wide}, 0, OccupancyFormat::kBinary,
                              {.resolution_m = 0.02, .max_range_m = 200, .max_bytes = 20 << 20});
  EXPECT_EQ(file.status().code(), absl::StatusCode::kResourceExhausted);
}

// The grid must find what OctoMap's own insertion finds; the two round rays that graze a corner
// differently.
class OccupancyEvidence : public testing::TestWithParam<SensorModel> {};
INSTANTIATE_TEST_SUITE_P(SensorModels, OccupancyEvidence,
                         testing::Values(SensorModel{}, SensorModel{0.9, 0.45, 0.05, 0.99}));

TEST_P(OccupancyEvidence, AgreesWithOctomapsOwnInsertion) {
  std::mt19937 rng(8);
  const SensorModel sensor = GetParam();
  const OccupancyOptions options{.resolution_m = 0.2, .max_range_m = 20, .sensor = sensor};
  octomap::OcTree expected(options.resolution_m);
  expected.setProbHit(sensor.hit);
  expected.setProbMiss(sensor.miss);
  expected.setClampingThresMin(sensor.least);
  expected.setClampingThresMax(sensor.most);
  std::vector<LaidSubmap> submaps;
  for (uint32_t scan = 0; scan < 4; ++scan) {
    // Faces of a room around the sensor, all in range: cut rays differ on purpose.
    auto points = RandomPoints(&rng, 6000, MakeBox({-14, -6, -1}, {14, 6, 2}));
    for (SubmapPoint& p : points) (rng() % 2 ? p.y : p.z) = rng() % 2 ? 1.97f : -0.97f;
    const Pose T_map_submap = Pose::FromXyzRpy(0.53 * scan, 0.21, 0.13, 0, 0, 0.3 * scan);
    submaps.push_back(MakeSubmap("alice", scan, points, T_map_submap));
    octomap::Pointcloud cloud;
    for (const SubmapPoint& p : points) {
      const Eigen::Vector3d q = T_map_submap * Eigen::Vector3d(p.x, p.y, p.z);
      cloud.push_back(q.x(), q.y(), q.z());
    }
    const Eigen::Vector3d o = T_map_submap.translation();
    expected.insertPointCloud(cloud, octomap::point3d(o.x(), o.y(), o.z()), options.max_range_m,
                              false, true);
  }
  const auto file = WriteFile(submaps, 0, OccupancyFormat::kFull, options);
  ASSERT_TRUE(file.ok()) << file.status();
  const auto actual = ReadTree(*file, OccupancyFormat::kFull);
  ASSERT_NE(actual, nullptr);
  expected.expand();
  actual->expand();
  int64_t same = 0, all = 0;
  for (auto leaf = expected.begin_leafs(); leaf != expected.end_leafs(); ++leaf, ++all) {
    const octomap::OcTreeNode* node = actual->search(leaf.getKey());
    same += node && std::abs(node->getLogOdds() - leaf->getLogOdds()) < 1e-4;
  }
  EXPECT_GT(all, 20000);
  EXPECT_GT(static_cast<double>(same) / static_cast<double>(all), 0.99);
  EXPECT_NEAR(static_cast<double>(actual->getNumLeafNodes()), static_cast<double>(all), 0.01 * all);
}

}  // namespace
}  // namespace isthmus::composition
