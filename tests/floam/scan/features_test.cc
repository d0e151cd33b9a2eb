#include "floam/scan/features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::MakeScan;
using testing::Room;
using testing::Sensor;
using testing::Still;

RingScan Sorted(const Scan& scan) {
  RingScan sorted;
  EXPECT_TRUE(RingSorter().Sort(scan, *FindSensorModel("vlp16"), 0.1, &sorted).ok());
  return sorted;
}

Features Extract(const RingScan& scan) {
  Features features;
  FeatureExtractor(FeatureOptions()).Extract(scan, &features);
  return features;
}

// To the nearer of the empty room's two faces across each axis; the sensor stands at its origin.
std::array<double, 3> DistancesToFaces(const TimedPoint& p) {
  return {10 - std::abs(p.position.x()), 7 - std::abs(p.position.y()),
          std::min(std::abs(p.position.z() + 1.2), std::abs(p.position.z() - 3.8))};
}

TEST(Smoothness, IsEquationOneOfThePaper) {
  std::vector<RingPoint> ring(11);
  for (int k = 0; k < 11; ++k) {
    ring[k].x = 4;
    ring[k].y = 0.1F * static_cast<float>(k - 5);
    ring[k].range = std::hypot(ring[k].x, ring[k].y);
  }
  EXPECT_NEAR(Smoothness(&ring[5], 5), 0, 1e-6);
  // A tip 0.2 m nearer than its ten neighbours: |sum| = 10 * 0.2, over 10 * 3.8.
  ring[5].x = ring[5].range = 3.8F;
  EXPECT_NEAR(Smoothness(&ring[5], 5), 0.2 / 3.8, 1e-5);
}

TEST(Features, KnowTheirRing) {
  const Features features = Extract(Sorted(MakeScan(testing::FurnishedRoom(), Still, Sensor(), 0)));
  for (const auto* points : {&features.edges, &features.surfaces, &features.map_surfaces}) {
    ASSERT_FALSE(points->empty());
    for (const TimedPoint& p : *points) {
      const double elevation = std::asin(p.position.z() / p.position.norm());
      EXPECT_EQ(p.ring, std::lround((elevation + 0.2618) / (2 * 0.2618) * 15));
    }
  }
}

TEST(Features, EdgesAreCornersAndSurfacesAreWalls) {
  const Room room;  // Empty.
  const Features features = Extract(Sorted(MakeScan(room, Still, Sensor(), 0)));
  ASSERT_GT(features.edges.size(), 20u);
  for (const TimedPoint& edge : features.edges) {
    // Two of the six faces meet there.
    std::array<double, 3> to_face = DistancesToFaces(edge);
    std::sort(to_face.begin(), to_face.end());
    EXPECT_LT(std::hypot(to_face[0], to_face[1]), 0.3) << edge.position.transpose();
  }
  ASSERT_GT(features.surfaces.size(), 300u);
  for (const TimedPoint& surface : features.surfaces) {
    const std::array<double, 3> to_face = DistancesToFaces(surface);
    EXPECT_LT(*std::min_element(to_face.begin(), to_face.end()), 0.06)
        << surface.position.transpose();
    EXPECT_GT(surface.weight, 0);
    EXPECT_LE(surface.weight, 1);
  }
  EXPECT_GT(features.map_surfaces.size(), features.surfaces.size());
}

TEST(Features, NoneBesideAGapOrAnOcclusion) {
  Room room;
  room.boxes = {{{3, -0.4, -1.2}, {3.8, 0.4, 3.8}}};  // A pillar before the wall at x = 10.
  const Features features = Extract(Sorted(MakeScan(room, Still, Sensor(), 0)));
  // The pillar hides the wall where |y| < 0.4 / 3 * 10; five columns on are within its shadow's
  // border.
  const double border = 10 * 0.4 / 3;
  const double five_columns = 5 * 10 * 2 * M_PI / 1200;
  for (const auto* points : {&features.surfaces, &features.edges}) {
    for (const TimedPoint& p : *points) {
      if (p.position.x() < 9.5F) continue;
      EXPECT_GT(std::abs(p.position.y()), border + 0.8 * five_columns) << p.position.transpose();
    }
  }
}

TEST(Features, NoneAtGrazingIncidence) {
  Room room;
  room.boxes = {{{2, 0.25, -1.2}, {9, 1, 3.8}}};  // A long side, seen at 7 degrees and less.
  const Features features = Extract(Sorted(MakeScan(room, Still, Sensor(), 0)));
  for (const TimedPoint& p : features.surfaces) {
    const bool on_side = std::abs(p.position.y() - 0.25F) < 0.04F && p.position.x() > 2.3F &&
                         p.position.x() < 8.7F && std::abs(p.position.z() + 1.2F) > 0.1F;
    EXPECT_FALSE(on_side) << p.position.transpose();
  }
}

TEST(Features, SurviveValuesThatAreNotFinite) {
  RingScan scan = Sorted(MakeScan(testing::FurnishedRoom(), Still, Sensor(), 0));
  for (size_t i = 0; i < scan.points.size(); i += 97) {
    scan.points[i].x = std::numeric_limits<float>::quiet_NaN();
  }
  const Features features = Extract(scan);
  EXPECT_GT(features.surfaces.size(), 100u);
  for (const auto* points : {&features.surfaces, &features.edges, &features.map_surfaces}) {
    for (const TimedPoint& p : *points) EXPECT_TRUE(p.position.allFinite());
  }
}

TEST(Features, NoneInAnEmptyScan) {
  const Features features = Extract(RingScan());
  EXPECT_TRUE(features.surfaces.empty());
  EXPECT_TRUE(features.edges.empty());
}

// A lift, a store room: voxels of their usual size would leave too little to hold on to.
TEST(Features, AreDenserInASmallRoom) {
  Room closet;
  closet.walls = {{-1.4, -1.1, -1}, {1.2, 1.5, 1.3}};
  const RingScan small = Sorted(MakeScan(closet, Still, Sensor(), 0));
  const RingScan large = Sorted(MakeScan(testing::FurnishedRoom(), Still, Sensor(), 0));
  FeatureOptions rigid;
  rigid.few_surfaces = 0;
  FeatureExtractor fixed(rigid), adaptive{FeatureOptions()};
  Features features, usual;
  fixed.Extract(small, &features);
  EXPECT_LT(features.surfaces.size(), 150u);
  adaptive.Extract(small, &features);
  EXPECT_GT(features.surfaces.size(), 800u);
  // And as usual again once there is more to see.
  for (int k = 0; k < 3; ++k) adaptive.Extract(large, &features);
  fixed.Extract(large, &usual);
  EXPECT_LE(features.surfaces.size(), 4 * usual.surfaces.size());
  EXPECT_LE(features.surfaces.size(), 4000u);
}

TEST(Features, AreThinnedToTheLimit) {
  FeatureOptions options;
  options.max_surfaces = 150;
  Features features;
  FeatureExtractor(options).Extract(Sorted(MakeScan(testing::FurnishedRoom(), Still, Sensor(), 0)),
                                    &features);
  EXPECT_EQ(features.surfaces.size(), 150u);
}

}  // namespace
}  // namespace isthmus::floam
