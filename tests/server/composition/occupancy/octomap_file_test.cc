// Files judged by OctoMap itself: it reads them, and writes the same bytes again.
#include "server/composition/occupancy/octomap_file.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <memory>
#include <random>
#include <sstream>
#include <vector>

#include "server/composition/occupancy/sensor_evidence.h"
#include "server/composition/occupancy/voxel_column.h"

namespace isthmus::composition {
namespace {

constexpr double kResolution = 0.1;
constexpr uint64_t kRoom = uint64_t{1} << 30;

// Boxes of equal log-odds, some as large as a cube and more, among single voxels. Around the
// origin, so that all signs occur.
std::vector<PlacedColumn> SomeColumns(uint32_t seed) {
  std::mt19937 rng(seed);
  const auto up_to = [&rng](int32_t most) {
    return static_cast<int32_t>(rng() % static_cast<uint32_t>(most + 1));
  };
  std::vector<PlacedColumn> columns;
  for (const ColumnKey key : {ColumnKey{-1, -1}, ColumnKey{0, -1}, ColumnKey{-1, 0},
                              ColumnKey{0, 0}, ColumnKey{3, -7}, ColumnKey{-512, 511}}) {
    VoxelColumn column;
    for (int box = 0; box < 12; ++box) {
      const bool is_whole = box == 0 && key.x < 3;
      const VoxelIndex from =
          is_whole ? VoxelIndex(0, 0, -64) : VoxelIndex(up_to(63), up_to(63), up_to(150) - 90);
      const VoxelIndex size =
          is_whole ? VoxelIndex(64, 64, 128) : VoxelIndex(up_to(20), up_to(20), up_to(20));
      const float log_odds =
          box % 3 == 0 ? LogOdds(0.1192) : 0.1f * static_cast<float>(up_to(40) - 15);
      for (int32_t x = from.x(); x < std::min(64, from.x() + size.x()); ++x) {
        for (int32_t y = from.y(); y < std::min(64, from.y() + size.y()); ++y) {
          for (int32_t z = from.z(); z < from.z() + size.z(); ++z) {
            column.At({x, y, z}) = {log_odds, 1};
          }
        }
      }
    }
    columns.push_back({key, std::make_shared<const PackedColumn>(column)});
  }
  return columns;
}

std::string BodyOf(const std::string& file) { return file.substr(file.find("\ndata\n")); }
std::string HeaderOf(const std::string& file) { return file.substr(0, file.find("\ndata\n")); }

std::unique_ptr<octomap::OcTree> TreeOf(const std::string& file) {
  std::istringstream stream(file);
  return std::unique_ptr<octomap::OcTree>(
      dynamic_cast<octomap::OcTree*>(octomap::AbstractOcTree::read(stream)));
}

TEST(OctomapFile, FullIsWhatOctomapWrites) {
  for (uint32_t seed = 0; seed < 5; ++seed) {
    const auto file = FormatOctomap(SomeColumns(seed), OccupancyFormat::kFull, kResolution, kRoom);
    ASSERT_TRUE(file.ok()) << file.status();
    const auto tree = TreeOf(*file);
    ASSERT_NE(tree, nullptr);
    // As though each voxel had been set by itself.
    tree->expand();
    tree->updateInnerOccupancy();
    tree->prune();
    std::ostringstream again;
    tree->write(again);
    EXPECT_TRUE(again.str() == *file) << again.str().size() << " and " << file->size();
  }
}

TEST(OctomapFile, BinaryIsWhatOctomapWrites) {
  for (uint32_t seed = 0; seed < 5; ++seed) {
    const auto columns = SomeColumns(seed);
    const auto full = FormatOctomap(columns, OccupancyFormat::kFull, kResolution, kRoom);
    const auto file = FormatOctomap(columns, OccupancyFormat::kBinary, kResolution, kRoom);
    ASSERT_TRUE(file.ok()) << file.status();
    const auto tree = TreeOf(*full);
    ASSERT_NE(tree, nullptr);
    std::ostringstream again;
    tree->writeBinary(again);  // Makes it its maximum likelihood, and prunes.
    EXPECT_TRUE(BodyOf(again.str()) == BodyOf(*file));
    EXPECT_TRUE(HeaderOf(*file).ends_with(HeaderOf(again.str()).substr(again.str().find("id "))))
        << HeaderOf(*file) << "\n"
        << HeaderOf(again.str());
    std::istringstream stream(*file);
    octomap::OcTree read(kResolution);
    ASSERT_TRUE(read.readBinary(stream));
    EXPECT_EQ(read.size(), tree->size());
  }
}

TEST(OctomapFile, NoColumnsAreAnEmptyTree) {
  const auto file = FormatOctomap({}, OccupancyFormat::kFull, kResolution, kRoom);
  std::ostringstream expected;
  octomap::OcTree(kResolution).write(expected);
  EXPECT_EQ(*file, expected.str());
}

TEST(OctomapFile, HasALimit) {
  const auto columns = SomeColumns(1);
  for (const OccupancyFormat format : {OccupancyFormat::kBinary, OccupancyFormat::kFull}) {
    const auto file = FormatOctomap(columns, format, kResolution, kRoom);
    const auto more = FormatOctomap(columns, format, kResolution, file->size() / 2);
    EXPECT_EQ(more.status().code(), absl::StatusCode::kResourceExhausted);
  }
}

TEST(SensorEvidence, IsOctomapsOwn) {
  const octomap::OcTree tree(kResolution);
  const SensorModel model;
  EXPECT_EQ(tree.getProbHitLog(), LogOdds(model.hit));
  EXPECT_EQ(tree.getProbMissLog(), LogOdds(model.miss));
  EXPECT_EQ(tree.getClampingThresMinLog(), LogOdds(model.least));
  EXPECT_EQ(tree.getClampingThresMaxLog(), LogOdds(model.most));
  EXPECT_EQ(tree.getOccupancyThresLog(), kOccupiedLogOdds);
}

}  // namespace
}  // namespace isthmus::composition
