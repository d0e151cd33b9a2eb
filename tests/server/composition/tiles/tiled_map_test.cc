#include "server/composition/tiles/tiled_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "server/composition/composer.h"
#include "tests/server/composition/test_maps.h"

namespace isthmus::composition {
namespace {

using ::testing::IsEmpty;

class RegionRead : public ::testing::Test {
 protected:
  RegionRead() {
    std::mt19937 rng(11);
    std::vector<LaidSubmap> submaps;
    const Box room = MakeBox({-30, -20, -2}, {30, 20, 5});
    for (const char* robot : {"alice", "bob", "carol"}) {
      submaps.push_back(MakeSubmap(robot, 0, RandomPoints(&rng, 4000, room)));
    }
    Composer composer({.tile_m = 9});
    map_ = Compose(&composer, 1, submaps);
    all_ = ReadAll(*map_);
  }

  // Expects the region to give exactly the points of the map that `keep` picks.
  template <typename Keep>
  void ExpectExactly(const Region& region, const Keep& keep) {
    std::vector<MapPoint> expected;
    for (const MapPoint& p : all_) {
      if (keep(p, Eigen::Vector3d(p.x, p.y, p.z))) expected.push_back(p);
    }
    EXPECT_EQ(Sorted(ReadAll(*map_, region)), Sorted(expected));
  }

  std::mt19937 rng_{12};
  std::shared_ptr<const ComposedMap> map_;
  std::vector<MapPoint> all_;
};

TEST_F(RegionRead, WholeMapHasItsCountAndBounds) {
  EXPECT_EQ(all_.size(), map_->point_count(0));
  Box bounds;
  for (const MapPoint& p : all_) bounds.Extend(Eigen::Vector3d(p.x, p.y, p.z));
  EXPECT_EQ(bounds.min, map_->bounds(0).min);
  EXPECT_EQ(bounds.max, map_->bounds(0).max);
}

TEST_F(RegionRead, ShapesMatchBruteForce) {
  std::uniform_real_distribution<double> place(-30, 30), size(1, 25);
  const auto somewhere = [&] { return Eigen::Vector3d(place(rng_), place(rng_), place(rng_) / 8); };
  for (int round = 0; round < 30; ++round) {
    Region region;
    const HeightBand heights{-1 - size(rng_) / 8, size(rng_) / 8};
    if (round % 3 == 0) {
      const Eigen::Vector3d at = somewhere();
      region.shape = std::make_shared<OrientedBoxShape>(
          Pose::FromXyzRpy(at.x(), at.y(), at.z(), 0.2, -0.1, place(rng_)),
          Eigen::Vector3d(size(rng_), size(rng_), size(rng_)));
    } else if (round % 3 == 1) {
      std::vector<Eigen::Vector2d> corners;
      for (int i = 0; i < 3 + round / 3; ++i) corners.emplace_back(somewhere().head<2>());
      region.shape = std::make_shared<PolygonShape>(corners, heights);
    } else {
      std::vector<Eigen::Vector3d> path;
      for (int i = 0; i <= round / 3; ++i) path.push_back(somewhere());
      region.shape = std::make_shared<CorridorShape>(path, size(rng_) / 2, heights);
    }
    region.robot = round % 4 == 0 ? 1 : -1;
    ExpectExactly(region, [&](const MapPoint& p, const Eigen::Vector3d& at) {
      return region.shape->Contains(at) && (region.robot < 0 || p.robot == 1);
    });
  }
}

// Points are filtered before they are thinned: another point of a voxel may stand for it.
TEST_F(RegionRead, TimesAndOwnFiltersMatchBruteForce) {
  std::vector<LaidSubmap> submaps;
  const Box room = MakeBox({-30, -20, -2}, {30, 20, 5});
  for (uint32_t i = 0; i < 4; ++i) {
    submaps.push_back(MakeSubmap("alice", i, RandomPoints(&rng_, 3000, room)));
  }
  Composer composer({.tile_m = 9});
  map_ = Compose(&composer, 1, submaps);
  all_ = ReadAll(*map_);
  Region region;
  region.seen_from = 1'000'000'060;
  region.seen_to = 1'000'000'120;
  size_t some = 0;
  ExpectExactly(region, [&](const MapPoint& p, const Eigen::Vector3d&) {
    some += p.stamp == 1'000'000'060 ? 1 : 0;
    return p.stamp == 1'000'000'060 || p.stamp == 1'000'000'120;
  });
  EXPECT_GT(some, 100u);
  region = {};
  region.keep = [](const MapPoint& p) { return p.intensity > 0.5F; };
  ExpectExactly(region,
                [](const MapPoint& p, const Eigen::Vector3d&) { return p.intensity > 0.5F; });
  // One point for each voxel in which there is any that is kept.
  region.resolution_m = 0.8;
  std::set<std::tuple<int, int, int>> voxels;
  for (const MapPoint& p : all_) {
    if (!region.keep(p)) continue;
    voxels.emplace(std::floor(p.x / 0.8), std::floor(p.y / 0.8), std::floor(p.z / 0.8));
  }
  EXPECT_NEAR(static_cast<double>(ReadAll(*map_, region).size()),
              static_cast<double>(voxels.size()), 3);
}

// A room from within: floor, ceiling and walls, seen from a way 0.8 m above the floor.
LaidSubmap RoomSubmap(uint32_t index, const Pose& T_map_submap) {
  std::vector<SubmapPoint> points;
  for (double x = 0.05; x < 12; x += 0.1) {
    for (double y = 0.05; y < 8; y += 0.1) {
      points.push_back(At(x - 6, y - 4, -0.8));
      points.push_back(At(x - 6, y - 4, 2.2));
    }
    for (double z = 0.05; z < 3; z += 0.1) {
      points.push_back(At(x - 6, -4, z - 0.8));
      points.push_back(At(x - 6, 4, z - 0.8));
    }
  }
  return MakeSubmap("alice", index, std::move(points), T_map_submap);
}

TEST_F(RegionRead, PointsHaveClassesByWhichTheyAreChosen) {
  const Pose aside = Pose::FromXyzRpy(0.03, -0.02, 0, 0, 0, 0.01);
  Composer composer({.tile_m = 9});
  map_ = Compose(&composer, 1, {RoomSubmap(0, Pose()), RoomSubmap(1, aside)});
  all_ = ReadAll(*map_);
  size_t right = 0;
  for (const MapPoint& p : all_) {
    right += p.label == (p.z < -0.7F  ? PointClass::kGround
                         : p.z > 2.1F ? PointClass::kCeiling
                                      : PointClass::kWall)
                 ? 1
                 : 0;
  }
  EXPECT_GT(static_cast<double>(right), 0.9 * static_cast<double>(all_.size()));
  Region region;
  region.classes = PointClasses({PointClass::kGround, PointClass::kCeiling});
  size_t chosen = 0;
  ExpectExactly(region, [&](const MapPoint& p, const Eigen::Vector3d&) {
    const bool is_chosen = p.label == PointClass::kGround || p.label == PointClass::kCeiling;
    chosen += is_chosen ? 1 : 0;
    return is_chosen;
  });
  EXPECT_GT(chosen, 1000u);
}

// Labels belong to submaps: wherever these lie, and in whatever order they came.
TEST_F(RegionRead, ClassesAreThoseOfARebuild) {
  Composer composer({.tile_m = 9});
  const Pose away = Pose::FromXyzRpy(3, 1, 0.2, 0, 0, 0.5);
  Compose(&composer, 1, {RoomSubmap(1, Pose())});
  Compose(&composer, 2, {RoomSubmap(0, away), RoomSubmap(1, away)});
  const auto moved = ReadAll(*Compose(&composer, 3, {RoomSubmap(0, Pose()), RoomSubmap(1, away)}));
  Composer anew({.tile_m = 9});
  const auto rebuilt = ReadAll(*Compose(&anew, 1, {RoomSubmap(0, Pose()), RoomSubmap(1, away)}));
  ASSERT_EQ(moved.size(), rebuilt.size());
  for (size_t i = 0; i < moved.size(); ++i) ASSERT_EQ(moved[i].label, rebuilt[i].label) << i;
}

// The skipped points and the rest make up the whole, wherever it was cut.
TEST_F(RegionRead, SkippingGoesOnWhereItWasCutOff) {
  Region regions[4];
  regions[1].resolution_m = 0.7;
  regions[2].box = MakeBox({-12, -9, -1}, {21, 8, 3});
  regions[3].robot = 2;
  for (Region& region : regions) {
    region.skip = 0;
    const std::vector<MapPoint> whole = ReadAll(*map_, region);
    for (size_t cut = 0; cut <= whole.size() + 10; cut += 1 + whole.size() / 7) {
      region.skip = cut;
      const std::vector<MapPoint> rest = ReadAll(*map_, region);
      const size_t skipped = std::min(cut, whole.size());
      ASSERT_EQ(InOrder(rest),
                InOrder({whole.begin() + static_cast<std::ptrdiff_t>(skipped), whole.end()}));
    }
  }
}

TEST_F(RegionRead, EndsBetweenTilesWhenToldTo) {
  Region region;
  int asked = 0;
  region.keep_on = [&] { return ++asked < 5; };
  const size_t some = ReadAll(*map_, region).size();
  EXPECT_EQ(asked, 5);
  EXPECT_LT(some, all_.size());
}

TEST_F(RegionRead, BoxesAndSpheresMatchBruteForce) {
  std::uniform_real_distribution<double> place(-35, 35), size(0, 25);
  for (int round = 0; round < 40; ++round) {
    Region region;
    const Eigen::Vector3d corner(place(rng_), place(rng_), place(rng_) / 8);
    region.box = MakeBox(corner, corner + Eigen::Vector3d(size(rng_), size(rng_), size(rng_)));
    ExpectExactly(
        region, [&](const MapPoint&, const Eigen::Vector3d& p) { return region.box.Contains(p); });

    Region ball;
    ball.has_sphere = true;
    ball.center = corner;
    ball.radius_m = size(rng_);
    const auto in_ball = [&](const Eigen::Vector3d& p) {
      return (p - ball.center).squaredNorm() <= ball.radius_m * ball.radius_m;
    };
    ExpectExactly(ball, [&](const MapPoint&, const Eigen::Vector3d& p) { return in_ball(p); });

    Region both = ball;
    both.box = region.box;
    both.robot = round % 3;
    ExpectExactly(both, [&](const MapPoint& m, const Eigen::Vector3d& p) {
      return in_ball(p) && region.box.Contains(p) && m.robot == static_cast<uint32_t>(both.robot);
    });
  }
}

TEST_F(RegionRead, OneRobotOnly) {
  Region region;
  region.robot = 1;
  ExpectExactly(region, [](const MapPoint& m, const Eigen::Vector3d&) { return m.robot == 1; });
}

TEST_F(RegionRead, WhatDoesNotExistIsEmpty) {
  Region no_component, no_robot, negative_ball, nowhere;
  no_component.component = 5;
  no_robot.robot = 3;
  negative_ball.has_sphere = true;
  negative_ball.radius_m = -100;
  nowhere.box = MakeBox({500, 500, 500}, {600, 600, 600});
  for (const Region& region : {no_component, no_robot, negative_ball, nowhere}) {
    EXPECT_THAT(ReadAll(*map_, region), IsEmpty());
  }
  EXPECT_EQ(map_->point_count(5), 0u);
  EXPECT_TRUE(map_->bounds(5).empty());
}

TEST_F(RegionRead, ResolutionThinsToOnePointPerVoxel) {
  const auto voxel_of = [](const MapPoint& p) {
    return std::make_tuple(std::floor(p.x / 2.f), std::floor(p.y / 2.f), std::floor(p.z / 2.f));
  };
  std::set<std::tuple<float, float, float>> expected;
  for (const MapPoint& p : all_) expected.insert(voxel_of(p));
  Region region;
  region.resolution_m = 2;
  const auto thinned = ReadAll(*map_, region);
  std::set<std::tuple<float, float, float>> got;
  for (const MapPoint& p : thinned) got.insert(voxel_of(p));
  EXPECT_EQ(got, expected);
  EXPECT_EQ(thinned.size(), expected.size());

  // Points that voxels keep were in the map.
  const auto whole = Sorted(all_);
  for (const auto& p : Sorted(thinned)) {
    EXPECT_TRUE(std::binary_search(whole.begin(), whole.end(), p));
  }
}

// For any position of the voxels to the tiles', levels and the region's faces; read from a coarse
// level or not. The robots of this map lie over each other.
TEST_F(RegionRead, ResolutionsInWholeVoxelsThinToOnePointPerVoxelOfTheRegion) {
  std::uniform_real_distribution<double> place(-35, 20), size(5, 40);
  for (const int block : {1, 2, 3, 4, 6, 8, 10, 16, 18, 64, 90, 128, 256}) {
    Region region;
    region.resolution_m = block * 0.1;
    for (int round = 0; round < 6; ++round) {
      if (round > 0) {
        const Eigen::Vector3d corner(place(rng_), place(rng_), -3);
        region.box = MakeBox(corner, corner + Eigen::Vector3d(size(rng_), size(rng_), 9));
      }
      region.robot = round % 4 - 1;
      const auto voxel_of = [&](const MapPoint& p) {
        const auto index = [&](float at) {
          return std::floor(std::floor(at * 10.f) / static_cast<float>(block));
        };
        return std::make_tuple(index(p.x), index(p.y), index(p.z));
      };
      std::set<std::tuple<float, float, float>> expected, got;
      for (const MapPoint& p : all_) {
        if (region.robot >= 0 && p.robot != static_cast<uint32_t>(region.robot)) continue;
        if (round > 0 && !region.box.Contains({p.x, p.y, p.z})) continue;
        expected.insert(voxel_of(p));
      }
      const auto thinned = ReadAll(*map_, region);
      for (const MapPoint& p : thinned) {
        got.insert(voxel_of(p));
        EXPECT_TRUE(round == 0 || region.box.Contains({p.x, p.y, p.z}));
      }
      ASSERT_EQ(got, expected) << block;
      ASSERT_EQ(thinned.size(), expected.size()) << block;
    }
  }
}

// Without a look at any point.
TEST_F(RegionRead, BoundsHoldTheCount) {
  std::uniform_real_distribution<double> place(-30, 30);
  int loose = 0;
  for (const double resolution_m : {0., 0.1, 0.2, 0.4, 0.5, 0.8, 1.6, 3.2, 100.}) {
    for (int round = 0; round < 8; ++round) {
      Region region;
      region.resolution_m = resolution_m;
      region.robot = round % 4 - 1;
      if (round >= 4) {
        for (int i = 0; i < 2; ++i) region.box.Extend({place(rng_), place(rng_), 9. * i - 4});
      }
      if (round == 7) region.seen_from = 1;
      const PointBounds bounds = map_->BoundsOf(region);
      const size_t count = ReadAll(*map_, region).size();
      EXPECT_LE(bounds.least, count) << resolution_m << ", " << round;
      EXPECT_GE(bounds.most, count) << resolution_m << ", " << round;
      loose += bounds.least < bounds.most ? 1 : 0;
      if (round < 4 && (resolution_m == 0 || (region.robot >= 0 && resolution_m == 0.1))) {
        EXPECT_EQ(bounds.least, bounds.most) << resolution_m << ", " << round;
      }
    }
  }
  EXPECT_GT(loose, 10);
}

TEST_F(RegionRead, SenselessResolutionReadsAsComposed) {
  for (const double resolution : {-1., std::numeric_limits<double>::quiet_NaN()}) {
    Region region;
    region.resolution_m = resolution;
    EXPECT_EQ(ReadAll(*map_, region).size(), all_.size());
  }
}

TEST_F(RegionRead, ChunksAreFullButTheLast) {
  for (const size_t chunk : {size_t{0}, size_t{1}, size_t{7}, size_t{1000}, size_t{1} << 40}) {
    const size_t limit = std::max<size_t>(chunk, 1);
    size_t total = 0, last = limit;
    const absl::Status status = map_->Read({}, chunk, [&](const std::vector<MapPoint>& points) {
      EXPECT_EQ(last, limit) << "a chunk after one that was not full";
      EXPECT_FALSE(points.empty());
      EXPECT_LE(points.size(), limit);
      last = points.size();
      total += points.size();
      return true;
    });
    EXPECT_TRUE(status.ok()) << status;
    EXPECT_EQ(total, all_.size());
  }
}

TEST_F(RegionRead, ReaderCanStop) {
  int calls = 0;
  const absl::Status status =
      map_->Read({}, 10, [&](const std::vector<MapPoint>&) { return ++calls < 3; });
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_EQ(calls, 3);
}

}  // namespace
}  // namespace isthmus::composition
