#include "server/matching/prepared/distinctive.h"

#include <gtest/gtest.h>

#include "server/matching/prepared/prepared_map.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

constexpr double kSpacingM = 4;

// Six shelves alike in a row along x, from x = 0 on, between two walls along it, and one wall
// across at its end, 6 m beyond the last one.
Scene Shelves() {
  Scene scene;
  for (int i = 0; i < 6; ++i) scene.boxes.push_back({{kSpacingM * i, 3, 1.5}, {0.5, 1.5, 1.5}});
  scene.boxes.push_back({{10, -2, 2}, {14, 0.2, 2}});
  scene.boxes.push_back({{26.2, 2, 2}, {0.2, 4, 2}});
  scene.boxes.push_back({{10, 0, -0.1}, {20, 20, 0.1}});
  return scene;
}

class DistinctiveTest : public ::testing::Test {
 protected:
  static Pose T_world_odom() { return Pose::FromXyzRpy(2, 0, 1, 0, 0, 0.7); }
  static void SetUpTestSuite() {
    map_ = Survey(Shelves(), {Way({{-2, 0, 1}, {21, 0, 1}}, 15), T_world_odom(), 0.01, 1});
    for (const auto& submap : map_.submaps) submaps_.push_back(PrepareSubmap(submap));
  }

  static DistinctiveMap Mark(const PreparedSubmaps& submaps, std::vector<Pose> moves) {
    return DistinctiveMap(submaps, Eigen::Vector3d::UnitZ(), std::move(moves));
  }

  // One shelf on.
  static Pose Move() {
    const Pose T_world_world(Eigen::Vector3d(kSpacingM, 0, 0));
    return T_world_odom().Inverse() * T_world_world * T_world_odom();
  }

  // Share of the upright points with world x in the range, above the floor, that the map has.
  static double ShareOf(const DistinctiveMap& map, const PreparedSubmaps& submaps, double from_x,
                        double to_x) {
    double asked = 0, has = 0;
    for (const auto& submap : submaps) {
      const Pose& T_odom_submap = submap->submap().T_odom_submap;
      for (const SurfacePoint& point : submap->surface()) {
        const Eigen::Vector3d p = T_odom_submap * point.position.cast<double>();
        const Eigen::Vector3d in_world = T_world_odom() * p;
        const double up = (T_odom_submap.rotation() * point.normal.cast<double>()).z();
        if (std::abs(up) > 0.3 || in_world.z() < 0.3 || in_world.y() < 0) continue;
        if (in_world.x() < from_x || in_world.x() > to_x) continue;
        ++asked;
        has += map.Has(p.cast<float>());
      }
    }
    EXPECT_GT(asked, 50);
    return has / asked;
  }

  static inline SessionMap map_;
  static inline PreparedSubmaps submaps_;
};

TEST_F(DistinctiveTest, WhatRepeatsIsNot) {
  const DistinctiveMap map = Mark(submaps_, {Move(), Move().Inverse()});
  EXPECT_LT(ShareOf(map, submaps_, 3, 17), 0.1) << "shelves";
  EXPECT_GT(ShareOf(map, submaps_, 25.7, 26.3), 0.9) << "the wall at the end";
}

TEST_F(DistinctiveTest, AllThatStandsIsWhereNothingRepeats) {
  const DistinctiveMap map = Mark(submaps_, {});
  EXPECT_GT(ShareOf(map, submaps_, -1, 27), 0.99);
  EXPECT_FALSE(map.Has(Eigen::Vector3f(500, 0, 0)));
}

// Added later, a submap is asked of all that came before.
TEST_F(DistinctiveTest, GrowsWithTheMap) {
  ASSERT_GE(submaps_.size(), 3u);
  const PreparedSubmaps first(submaps_.begin(), submaps_.end() - 1);
  const DistinctiveMap before = Mark(first, {Move(), Move().Inverse()});
  const DistinctiveMap map(before, submaps_);
  const PreparedSubmaps fresh(submaps_.end() - 1, submaps_.end());
  EXPECT_LT(ShareOf(map, fresh, 15, 17), 0.15) << "shelves";
  EXPECT_GT(ShareOf(map, fresh, 25.7, 26.3), 0.9) << "the wall at the end";
}

}  // namespace
}  // namespace isthmus::matching
