#include "floam/scan/neighbourhood.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "floam/scan/features.h"
#include "tests/floam/room.h"

namespace isthmus::floam {
namespace {

using testing::Loop;
using testing::MakeScanWithoutRings;
using testing::Raster;
using testing::Room;
using testing::Scattered;
using testing::Still;

RingScan Banded(const Scan& scan, const std::string& sensor = "unordered") {
  RingScan banded;
  const absl::Status status = RingSorter().Sort(scan, *FindSensorModel(sensor), 0.1, &banded);
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_FALSE(banded.in_rings());
  return banded;
}

Features Extracted(const RingScan& scan) {
  Features features;
  FeatureExtractor(FeatureOptions()).Extract(scan, &features);
  return features;
}

// To the nearest of the empty room's faces; the sensor stands at its origin.
double ToFace(const Eigen::Vector3f& p) {
  return std::min(
      {10 - std::abs(p.x()), 7 - std::abs(p.y()), std::abs(p.z() + 1.2F), std::abs(p.z() - 3.8F)});
}

TEST(Neighbourhood, WallsAreSurfacesWithTheirNormals) {
  const RingScan scan = Banded(MakeScanWithoutRings(Room(), Still, Scattered, 20000, 0));
  Neighbourhoods neighbourhoods;
  neighbourhoods.Build(scan);
  int walls = 0, found = 0;
  for (uint32_t i = 0; i < scan.points.size(); i += 7) {
    const RingPoint& p = scan.points[i];
    // A metre and more from the next face, a wall is all there is to see.
    if (std::abs(p.x) < 9.8F || std::abs(p.y) > 6 || p.z < -0.2F || p.z > 2.8F) continue;
    ++walls;
    const Neighbourhoods::Look look = neighbourhoods.At(i, 0.05F);
    if (look.are != Surroundings::kSurface) continue;
    ++found;
    EXPECT_LT(look.normal.x() * p.x, 0) << "towards the sensor";
    EXPECT_GT(std::abs(look.normal.x()), 0.97F);
    EXPECT_LT(look.deviation_m, 0.05F);
  }
  ASSERT_GT(walls, 100);
  EXPECT_GT(found, 0.95 * walls);
}

TEST(Neighbourhood, SurfacesLieOnWallsAndNothingIsAnEdgeInAnEmptyRoom) {
  for (const auto& pattern : {testing::Pattern(Raster), testing::Pattern(Scattered)}) {
    const Features features =
        Extracted(Banded(MakeScanWithoutRings(Room(), Still, pattern, 20000, 0)));
    ASSERT_GT(features.surfaces.size(), 500u);
    EXPECT_GE(features.map_surfaces.size(), features.surfaces.size());
    for (const TimedPoint& p : features.map_surfaces) {
      EXPECT_LT(ToFace(p.position), 0.06) << p.position.transpose();
      EXPECT_GT(p.weight, 0);
      EXPECT_LE(p.weight, 1);
    }
    EXPECT_TRUE(features.edges.empty());
  }
}

// A pattern that does not repeat looks at a place early and late in the scan.
TEST(Neighbourhood, MotionWithinTheScanHidesNoSurface) {
  const Room room = testing::FurnishedRoom();
  const testing::Motion motion = Loop(1.5);
  const auto later = [&](double time_s) { return motion(time_s + 3); };
  const auto standing = [&](double) { return motion(3); };
  const size_t moving =
      Extracted(Banded(MakeScanWithoutRings(room, later, Scattered, 20000, 0))).map_surfaces.size();
  const size_t still = Extracted(Banded(MakeScanWithoutRings(room, standing, Scattered, 20000, 0)))
                           .map_surfaces.size();
  EXPECT_GT(static_cast<double>(moving), 0.9 * static_cast<double>(still));
}

TEST(Neighbourhood, APoleIsAnEdge) {
  Room room;
  const Eigen::Vector3d center(4, 1, 0);
  const Eigen::Vector3d half(0.03, 0.03, 10);
  room.boxes = {{center - half, center + half}};
  for (const auto& pattern : {testing::Pattern(Raster), testing::Pattern(Scattered)}) {
    const Features features =
        Extracted(Banded(MakeScanWithoutRings(room, Still, pattern, 20000, 0)));
    EXPECT_GE(features.edges.size(), 3u);
    for (const TimedPoint& edge : features.edges) {
      EXPECT_LT((edge.position.head<2>().cast<double>() - center.head<2>()).norm(), 0.15);
    }
    for (const TimedPoint& p : features.surfaces) {
      if (ToFace(p.position) < 0.06) continue;  // On the room's own faces.
      EXPECT_GT((p.position.head<2>().cast<double>() - center.head<2>()).norm(), 0.15);
    }
  }
}

TEST(Neighbourhood, BordersOfWhatHidesAreNoSurfaces) {
  Room room;
  room.boxes = {{{3, -1, -1.2}, {3.8, 1, 3.8}}};  // A pillar before the wall at x = 10.
  const Features features = Extracted(Banded(MakeScanWithoutRings(room, Still, Raster, 20000, 0)));
  const double shadow = 10 * 1.0 / 3;
  int beside = 0;
  for (const TimedPoint& p : features.map_surfaces) {
    // On the pillar's front or side, or on the room's walls, not in the air between.
    const Eigen::Vector3f& q = p.position;
    const bool front = std::abs(q.x() - 3) < 0.06F && std::abs(q.y()) < 1.01F;
    EXPECT_TRUE(front || ToFace(q) < 0.06) << q.transpose();
    if (q.x() > 9.9F && std::abs(q.y()) < shadow + 2 && std::abs(q.z()) < 1) ++beside;
  }
  EXPECT_GT(beside, 10) << "the wall is seen as soon as the pillar does not hide it";
}

TEST(Neighbourhood, GroundAtGrazingIncidenceIsNoSurface) {
  Room flat;
  flat.walls = {{-60, -60, -0.4}, {60, 60, 30}};
  const RingScan scan = Banded(MakeScanWithoutRings(flat, Still, Raster, 20000, 0));
  for (const TimedPoint& p : Extracted(scan).map_surfaces) {
    if (p.position.z() > -0.3F) continue;
    EXPECT_LT(p.position.norm(), 0.4 / std::sin(0.25)) << p.position.transpose();
  }
}

TEST(Neighbourhood, NothingComesOfNothing) {
  RingScan empty;
  empty.rings_from = Inference::kNone;
  EXPECT_TRUE(Extracted(empty).surfaces.empty());
  // All in one direction, and one for every neighbourhood.
  Scan line, lonely;
  line.has_time = lonely.has_time = true;
  for (int k = 0; k < 300; ++k) {
    const float t = -0.0003F * static_cast<float>(k);
    line.points.push_back({1 + 0.1F * static_cast<float>(k), 0, 0, 1, t, 0});
    const Eigen::Vector3d far = 20 * Scattered(7 * k, 300, 0);
    lonely.points.push_back({static_cast<float>(far.x()), static_cast<float>(far.y()),
                             static_cast<float>(far.z()), 1, t, 0});
  }
  for (const Scan& scan : {line, lonely}) {
    const Features features = Extracted(Banded(scan));
    for (const auto* points : {&features.surfaces, &features.edges, &features.map_surfaces}) {
      for (const TimedPoint& p : *points) EXPECT_TRUE(p.position.allFinite());
    }
  }
}

TEST(Neighbourhood, ValuesThatAreNotFiniteDoNoHarm) {
  RingScan scan = Banded(MakeScanWithoutRings(Room(), Still, Scattered, 20000, 0));
  const size_t whole = Extracted(scan).map_surfaces.size();
  for (size_t i = 0; i < scan.points.size(); i += 97) {
    scan.points[i].x = std::numeric_limits<float>::quiet_NaN();
    scan.points[i + 1].y = std::numeric_limits<float>::infinity();
  }
  const Features features = Extracted(scan);
  EXPECT_GT(static_cast<double>(features.map_surfaces.size()), 0.95 * static_cast<double>(whole));
  for (const TimedPoint& p : features.map_surfaces) EXPECT_LT(ToFace(p.position), 0.06);
}

// A hundred times as many points take no other way, and see the same.
TEST(Neighbourhood, DenseScansAreLookedAtInPart) {
  const Features features =
      Extracted(Banded(MakeScanWithoutRings(Room(), Still, Scattered, 300000, 0)));
  EXPECT_GT(features.surfaces.size(), 500u);
  for (const TimedPoint& p : features.map_surfaces) EXPECT_LT(ToFace(p.position), 0.06);
}

// Rows of a scan that sees little but ground: walls are kept.
TEST(Features, NoFacingOutvotesTheOthers) {
  Room hall;
  hall.walls = {{-60, -60, -1.2}, {12, 60, 30}};
  FeatureOptions fine;
  fine.surface_voxel_m = 0.1F;
  fine.map_voxel_m = 0.1F;
  Features features;
  FeatureExtractor(fine).Extract(Banded(MakeScanWithoutRings(hall, Still, Raster, 60000, 0)),
                                 &features);
  const auto ground = std::count_if(features.surfaces.begin(), features.surfaces.end(),
                                    [](const TimedPoint& p) { return p.position.z() < -1.1F; });
  EXPECT_LE(ground, 450);
  EXPECT_GT(static_cast<long>(features.surfaces.size()) - ground, 300);
}

}  // namespace
}  // namespace isthmus::floam
