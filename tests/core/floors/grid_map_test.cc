// Grid maps of small OctoMaps, written by OctoMap itself and read by map_server's rules.
#include "core/floors/grid_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <cmath>
#include <sstream>

namespace isthmus::floors {
namespace {

// Voxels of a tenth of a metre, of boxes in metres.
class Voxels {
 public:
  void Set(const Eigen::Vector3d& from, const Eigen::Vector3d& to, bool is_occupied) {
    for (double x = from.x() + 0.05; x < to.x(); x += 0.1) {
      for (double y = from.y() + 0.05; y < to.y(); y += 0.1) {
        for (double z = from.z() + 0.05; z < to.z(); z += 0.1) {
          tree_.setNodeValue(x, y, z, is_occupied ? 2.0F : -2.0F, true);
        }
      }
    }
  }
  std::string File() {
    tree_.updateInnerOccupancy();
    std::ostringstream file;
    tree_.writeBinary(file);
    return file.str();
  }

 private:
  octomap::OcTree tree_{0.1};
};

Floor FloorAlong(double z) {
  Floor floor;
  for (int i = 0; i < 8; ++i) floor.stations.emplace_back(0.55 + 0.5 * i, 1.05, z);
  floor.lowest_m = floor.highest_m = z;
  return floor;
}

// Ground, a wall, a sill of 10 cm and a ceiling, with free space above the ground.
std::string SmallRoom() {
  Voxels voxels;
  voxels.Set({0, 0, -0.1}, {5, 2, 0}, true);
  voxels.Set({0, 0, 0}, {5, 2, 1.8}, false);
  voxels.Set({3, 0, 0}, {3.1, 2, 1.8}, true);
  voxels.Set({1, 0, 0}, {1.1, 2, 0.1}, true);
  voxels.Set({0, 0, 1.8}, {5, 2, 1.9}, true);
  return voxels.File();
}

GridCell CellAt(const GridMap& map, double x, double y) {
  return map.At(std::lround(std::floor((x - map.origin.x()) / map.resolution_m)),
                std::lround(std::floor((y - map.origin.y()) / map.resolution_m)));
}

TEST(GridMapOf, WallsAreOccupiedGroundSillsAndCeilingsAreNot) {
  const auto map = GridOf(SmallRoom(), FloorAlong(0.55), std::nullopt);
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_NEAR(map->resolution_m, 0.1, 1e-12);
  EXPECT_NEAR(map->origin.x(), 0, 1e-9);
  EXPECT_EQ(CellAt(*map, 3.05, 1.05), GridCell::kOccupied);
  EXPECT_EQ(CellAt(*map, 2.05, 1.05), GridCell::kFree);
  EXPECT_EQ(CellAt(*map, 1.05, 1.05), GridCell::kFree) << "a sill that robots drive over";
  int occupied = 0;
  for (const GridCell cell : map->cells) occupied += cell == GridCell::kOccupied;
  EXPECT_EQ(occupied, 20) << "the wall alone";
}

TEST(GridMapOf, AFloorSlopesWithItsStations) {
  Voxels voxels;
  Floor floor;
  for (int i = 0; i < 100; ++i) {  // As steep as ramps of garages are: 15 %.
    const double x = 0.1 * i, ground = std::floor(0.15 * x * 10) / 10;
    voxels.Set({x, 0, ground - 0.1}, {x + 0.1, 2, ground}, true);
    voxels.Set({x, 0, ground}, {x + 0.1, 2, ground + 1}, false);
    floor.stations.emplace_back(x + 0.05, 1.05, ground + 0.65);
  }
  floor.lowest_m = 0.65;
  floor.highest_m = 2.1;
  const auto map = GridOf(voxels.File(), floor, std::nullopt);
  ASSERT_TRUE(map.ok());
  for (const GridCell cell : map->cells) EXPECT_NE(cell, GridCell::kOccupied);
}

TEST(GridMapOf, AFixedBandIsOfTheMap) {
  const auto map = GridOf(SmallRoom(), {}, HeightBand{0.01, 0.09});
  ASSERT_TRUE(map.ok());
  EXPECT_EQ(CellAt(*map, 1.05, 1.05), GridCell::kOccupied) << "the sill counts now";
  // No map server takes a map of no cells.
  EXPECT_TRUE(absl::IsNotFound(GridOf(SmallRoom(), {}, HeightBand{5, 6}).status()));
}

TEST(GridMapOf, DamagedFilesAreRefused) {
  const std::string room = SmallRoom();
  EXPECT_TRUE(absl::IsInvalidArgument(GridOf("no map", FloorAlong(1), {}).status()));
  EXPECT_TRUE(
      absl::IsInvalidArgument(GridOf(room.substr(0, room.size() - 3), FloorAlong(1), {}).status()));
}

// As map_server's trinary mode reads a pixel.
GridCell Interpreted(unsigned char pixel) {
  const double p = (255 - pixel) / 255.0;
  if (p > 0.65) return GridCell::kOccupied;
  return p < 0.196 ? GridCell::kFree : GridCell::kUnknown;
}

TEST(GridMapFile, ReadsBackByTheRulesOfMapServer) {
  GridMap map{0.05, {-1.5, 2.25}, 3, 2, {}};
  map.cells = {GridCell::kFree,    GridCell::kOccupied, GridCell::kUnknown,
               GridCell::kUnknown, GridCell::kFree,     GridCell::kFree};
  const std::string pgm = FormatPgm(map);
  std::istringstream header(pgm);
  std::string magic, comment;
  std::getline(header, magic);
  std::getline(header, comment);
  int width = 0, height = 0, most = 0;
  header >> width >> height >> most;
  EXPECT_EQ(magic, "P5");
  EXPECT_EQ(comment[0], '#');
  EXPECT_EQ(width, 3);
  EXPECT_EQ(height, 2);
  EXPECT_EQ(most, 255);
  const std::string pixels = pgm.substr(pgm.size() - 6);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      const auto pixel = static_cast<unsigned char>(pixels[static_cast<size_t>((1 - y) * 3 + x)]);
      EXPECT_EQ(Interpreted(pixel), map.At(x, y)) << x << ", " << y;
    }
  }
  EXPECT_EQ(FormatMapYaml(map, "hall.pgm"),
            "image: \"hall.pgm\"\nmode: trinary\nresolution: 0.05\norigin: [-1.5, 2.25, 0]\n"
            "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

}  // namespace
}  // namespace isthmus::floors
