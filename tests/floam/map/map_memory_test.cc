#include "floam/map/map_memory.h"

#include <gtest/gtest.h>

#include <vector>

namespace isthmus::floam {
namespace {

constexpr int kCellsPerTile = MapMemory::kCells * MapMemory::kCells;

Submap WithPoints(const std::vector<Eigen::Vector3f>& points, uint32_t index,
                  const Pose& T_odom_submap = Pose()) {
  Submap submap;
  submap.id.index = index;
  submap.T_odom_submap = T_odom_submap;
  submap.keyframes.resize(1);
  for (const Eigen::Vector3f& p : points) submap.points.push_back({p.x(), p.y(), p.z(), 0, 0});
  return submap;
}

std::vector<Eigen::Vector3f> Floor(float from, float to, float z) {
  std::vector<Eigen::Vector3f> points;
  for (float x = from + 0.1F; x < to; x += 0.2F) {
    for (float y = from + 0.1F; y < to; y += 0.2F) points.emplace_back(x, y, z);
  }
  return points;
}

void Add(const Submap& submap, MapMemory* memory) { memory->Add(submap, submap.T_odom_submap); }

MapMemory::Cell CellAt(const MapMemory& memory, double x, double y) {
  const MapMemory::TileIndex tile = MapMemory::TileAt(x, y);
  const auto* cells = memory.Cells(tile);
  if (cells == nullptr) return MapMemory::Cell::kUnknown;
  const int cx = static_cast<int>((x - tile.x * MapMemory::kTileM) / MapMemory::kCellM);
  const int cy = static_cast<int>((y - tile.y * MapMemory::kTileM) / MapMemory::kCellM);
  return cells->at(static_cast<size_t>(cy) * MapMemory::kCells + static_cast<size_t>(cx));
}

TEST(MapMemory, KeepsPointsWhereTheyAreInOdom) {
  MapMemory memory({});
  const Pose T_odom_submap = Pose::FromXyzRpy(-812.3, 1207.9, -3.1, 0.02, -0.01, 2.1);
  const Eigen::Vector3f p(3.17F, -11.03F, -1.234F);
  Add(WithPoints({p}, 0, T_odom_submap), &memory);
  const Eigen::Vector3d truth = T_odom_submap * p.cast<double>();
  std::vector<MapMemory::SeenPoint> points;
  memory.AppendPoints(MapMemory::TileAt(truth.x(), truth.y()), &points);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_LT((points[0].position.cast<double>() - truth).norm(), 0.001);
}

TEST(MapMemory, GrowsWithTheAreaAndNotWithTheDrive) {
  MapMemory memory({});
  const std::vector<Eigen::Vector3f> points = Floor(-12, 12, -1.1F);
  Add(WithPoints(points, 0), &memory);
  const size_t once = memory.voxel_count();
  EXPECT_EQ(once, points.size());
  for (uint32_t lap = 1; lap < 20; ++lap) Add(WithPoints(points, lap), &memory);
  EXPECT_EQ(memory.voxel_count(), once);
}

TEST(MapMemory, ForgetsWhatIsNoLongerThereWhenItLooksAgain) {
  MapMemory memory({});
  const auto wall_at = [](float x) {
    std::vector<Eigen::Vector3f> points = Floor(0, 6, -1.1F);
    for (float y = 0.1F; y < 6; y += 0.2F) {
      for (float z = -0.9F; z < 1.5F; z += 0.2F) points.emplace_back(x, y, z);
    }
    return points;
  };
  Add(WithPoints(wall_at(3.0F), 2), &memory);
  Add(WithPoints({{7, 3, 0}}, 40), &memory);
  EXPECT_EQ(CellAt(memory, 3.0, 2.5), MapMemory::Cell::kWall);  // Not looked at again.
  // The odometry has drifted by 0.8 m when it comes back.
  Add(WithPoints(wall_at(3.8F), 41), &memory);
  EXPECT_EQ(CellAt(memory, 3.8, 2.5), MapMemory::Cell::kWall);
  EXPECT_EQ(CellAt(memory, 3.0, 2.5), MapMemory::Cell::kFlat);
  // Submaps shortly after each other complete each other.
  Add(WithPoints(wall_at(4.6F), 42), &memory);
  EXPECT_EQ(CellAt(memory, 3.8, 2.5), MapMemory::Cell::kWall);
  EXPECT_EQ(CellAt(memory, 4.6, 2.5), MapMemory::Cell::kWall);
}

TEST(MapMemory, TellsWallsFromFloorsCeilingsAndTheUnknown) {
  MapMemory memory({});
  // A noisy floor on the border of two levels of voxels, a ceiling, and a wall at x = 3.
  std::vector<Eigen::Vector3f> points = Floor(0, 6, -1.01F);
  for (const Eigen::Vector3f& p : Floor(0, 6, -0.99F)) points.push_back(p);
  for (const Eigen::Vector3f& p : Floor(0, 6, 2.0F)) points.push_back(p);
  for (float y = 0.1F; y < 6; y += 0.2F) {
    for (float z = -0.5F; z < 1.5F; z += 0.3F) points.emplace_back(3.F, y, z);
  }
  Add(WithPoints(points, 0), &memory);
  EXPECT_EQ(CellAt(memory, 3.0, 2.5), MapMemory::Cell::kWall);
  EXPECT_EQ(CellAt(memory, 1.0, 2.5), MapMemory::Cell::kFlat);
  EXPECT_EQ(CellAt(memory, 5.0, 5.0), MapMemory::Cell::kFlat);
  EXPECT_EQ(CellAt(memory, 7.0, 2.5), MapMemory::Cell::kUnknown);
  EXPECT_EQ(memory.Cells({40, 40}), nullptr);
}

TEST(MapMemory, LeavesOutWhatIsTooFarFromItsKeyframe) {
  MapMemoryOptions options;
  options.max_range_m = 10;
  MapMemory memory(options);
  Add(WithPoints({{9.F, 0.F, 0.F}, {11.F, 0.F, 0.F}}, 0), &memory);
  EXPECT_EQ(memory.voxel_count(), 1u);
}

TEST(MapMemory, LetsGoOfWhatWasNotSeenForLongest) {
  const std::vector<Eigen::Vector3f> here = Floor(0, 6, -1.1F), there = Floor(12, 18, -1.1F),
                                     elsewhere = Floor(-12, -6, -1.1F);
  MapMemoryOptions options;
  options.max_voxels = 2 * here.size() + here.size() / 2;
  MapMemory memory(options);
  Add(WithPoints(here, 0), &memory);
  Add(WithPoints(there, 1), &memory);
  Add(WithPoints(here, 2), &memory);
  Add(WithPoints(elsewhere, 3), &memory);
  EXPECT_LE(memory.voxel_count(), options.max_voxels);
  EXPECT_EQ(CellAt(memory, 2, 2), MapMemory::Cell::kFlat);
  EXPECT_EQ(CellAt(memory, -8, -8), MapMemory::Cell::kFlat);
  EXPECT_EQ(CellAt(memory, 14, 14), MapMemory::Cell::kUnknown);
}

TEST(MapMemory, RemembersWhereTheSensorWasOncePerSquare) {
  MapMemory memory({});
  Submap submap;
  for (int k = 0; k < 100; ++k) {
    submap.keyframes.push_back({0, 0, Pose(Eigen::Vector3d(0.05 + 0.1 * (k % 50), 0.3, 0.01 * k))});
  }
  Add(submap, &memory);
  const std::vector<Eigen::Vector3d> sensors = memory.SensorPositions();
  EXPECT_EQ(sensors.size(), 3u);
  for (const Eigen::Vector3d& sensor : sensors) EXPECT_GT(sensor.z(), 0.5);  // The second pass.
}

TEST(MapMemory, VisitsEveryTileAround) {
  int tiles = 0;
  bool own = false;
  MapMemory::ForTilesAround({1.0, -1.0}, 6.4, [&](MapMemory::TileIndex tile) {
    ++tiles;
    own = own || tile == MapMemory::TileAt(1.0, -1.0);
  });
  EXPECT_EQ(tiles, 9);
  EXPECT_TRUE(own);
  static_assert(kCellsPerTile == 256);
}

}  // namespace
}  // namespace isthmus::floam
