// The true classes of what the simulator builds and measures.
#include "core/map/point_class.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "lab/simulation/simulator.h"
#include "lab/simulation/wild/wild.h"

namespace isthmus::simulation {
namespace {

using enum PointClass;

std::unique_ptr<Simulator> WithClasses(const std::string& world, uint64_t seed, int walkers = 0) {
  Options options{.world = world, .seconds = 20, .walkers = walkers, .seed = seed};
  options.robots = 1;
  options.truth = Truth::kClass;
  return *Simulator::Create(options);
}

std::vector<std::string> AllWorlds() {
  std::vector<std::string> names = WorldNames();
  for (const std::string& kind : WildKinds()) names.push_back("wild-" + kind);
  return names;
}

// Classes of the first surfaces from places all along the way.
std::vector<PointClass> Seen(const Simulator& simulator, const Eigen::Vector3f& direction) {
  constexpr int kPlaces = 100;
  const RayCaster caster(simulator.world().mesh);
  std::vector<PointClass> seen;
  for (int i = 0; i < kPlaces; ++i) {
    const double seconds = simulator.options().seconds * i / kPlaces;
    const Ray ray{simulator.PoseAt(0, seconds).translation().cast<float>(), direction};
    Hit hit;
    caster.Cast({&ray, 1}, 100, {&hit, 1});
    seen.push_back(hit.surface);
  }
  return seen;
}

// Shares of the points of some scans, by class.
std::array<double, kPointClasses> Shares(const Simulator& simulator) {
  std::array<double, kPointClasses> shares = {};
  double all = 0;
  for (int scan = 0; scan < simulator.scan_count(); scan += 20) {
    for (const ScanPoint& point : simulator.MakeScan(0, scan).points) {
      shares.at(static_cast<size_t>(point.intensity)) += 1;
      ++all;
    }
  }
  for (double& share : shares) share /= all;
  return shares;
}

// Every class of `there` is in the scans, and none but these and points of nothing (drops, dust);
// the odd ray slips through a crack and sees ground from below.
void ExpectOnly(const std::vector<PointClass>& there, const std::vector<std::string>& worlds) {
  constexpr double kOdd = 0.0005;
  std::array<double, kPointClasses> most = {};
  for (const std::string& world : worlds) {
    for (const uint64_t seed : {11, 12, 13, 14}) {
      const auto shares = Shares(*WithClasses(world, seed));
      for (size_t i = 0; i < most.size(); ++i) most[i] = std::max(most[i], shares[i]);
    }
  }
  for (int i = 1; i < kPointClasses; ++i) {
    const auto point_class = static_cast<PointClass>(i);
    const bool expected = std::ranges::count(there, point_class) > 0;
    EXPECT_EQ(most[i] > kOdd, expected) << worlds.front() << " " << ToString(point_class);
  }
}

class ClassedWorld : public ::testing::TestWithParam<std::string> {};

TEST_P(ClassedWorld, KnowsWhatEverySurfaceIs) {
  for (const uint64_t seed : {4, 5}) {
    const auto simulator = WithClasses(GetParam(), seed);
    const Mesh& mesh = simulator->world().mesh;
    ASSERT_EQ(mesh.classes.size(), mesh.triangles.size());
    EXPECT_EQ(std::ranges::count(mesh.classes, kUnknown), 0) << seed;
    EXPECT_EQ(std::ranges::count(mesh.classes, kMover), 0) << seed;
  }
}

TEST_P(ClassedWorld, HasGroundBelowTheWay) {
  for (const uint64_t seed : {4, 5}) {
    const auto below = Seen(*WithClasses(GetParam(), seed), -Eigen::Vector3f::UnitZ());
    EXPECT_GE(std::ranges::count(below, kGround), 95) << seed;
  }
}

TEST_P(ClassedWorld, HasACeilingOrNothingAboveTheWay) {
  for (const uint64_t seed : {4, 5}) {
    const auto above = Seen(*WithClasses(GetParam(), seed), Eigen::Vector3f::UnitZ());
    for (const PointClass wrong : {kGround, kWall, kVehicle, kMover}) {
      EXPECT_LE(std::ranges::count(above, wrong), 5) << seed << " " << ToString(wrong);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Worlds, ClassedWorld, ::testing::ValuesIn(AllWorlds()), [](auto test) {
  std::ranges::replace(test.param, '-', '_');
  return test.param;
});

TEST(PointClasses, OfScansAreThoseOfTheWorld) {
  ExpectOnly({kGround, kCeiling, kWall, kPole, kObject}, {"museum"});
  ExpectOnly({kGround, kCeiling, kWall, kObject}, {"warehouse", "corridor"});
  ExpectOnly({kGround, kPole, kVegetation, kObject}, {"wild-forest"});
  ExpectOnly({kGround, kCeiling, kWall}, {"wild-mine"});
  ExpectOnly({kGround, kCeiling, kWall, kStructure}, {"wild-tunnel"});
  ExpectOnly({kGround, kObject}, {"wild-yard"});
  const auto campus = Shares(*WithClasses("campus", 11));
  for (const PointClass there : {kGround, kWall, kPole, kVegetation, kVehicle}) {
    EXPECT_GT(campus.at(static_cast<size_t>(there)), 0.001) << ToString(there);
  }
}

TEST(PointClasses, OfScansChangeNothingButIntensity) {
  Options options{.world = "wild-crowd", .robots = 1, .seconds = 5, .seed = 3};
  std::vector<Scan> scans;
  for (const Truth truth : {Truth::kNone, Truth::kMoving, Truth::kClass}) {
    options.truth = truth;
    scans.push_back((*Simulator::Create(options))->MakeScan(0, 20));
  }
  int moving = 0;
  ASSERT_EQ(scans[1].points.size(), scans[0].points.size());
  ASSERT_EQ(scans[2].points.size(), scans[0].points.size());
  for (size_t i = 0; i < scans[0].points.size(); ++i) {
    const ScanPoint &none = scans[0].points[i], &moves = scans[1].points[i],
                    &is = scans[2].points[i];
    ASSERT_EQ(std::tie(none.x, none.y, none.z, none.time), std::tie(is.x, is.y, is.z, is.time));
    ASSERT_EQ(std::tie(none.x, none.y, none.z), std::tie(moves.x, moves.y, moves.z));
    const auto point_class = static_cast<PointClass>(is.intensity);
    // All cars of a crowd drive.
    EXPECT_EQ(moves.intensity == 255, point_class == kMover || point_class == kVehicle) << i;
    moving += moves.intensity == 255 ? 1 : 0;
  }
  EXPECT_GT(moving, 0);
}

TEST(PointClasses, OfPeopleAreMovers) {
  const auto shares = Shares(*WithClasses("museum", 3, 40));
  EXPECT_GT(shares[static_cast<size_t>(kMover)], 0.005);
  EXPECT_EQ(shares[static_cast<size_t>(kVehicle)], 0);
}

TEST(PointClasses, OfAThinFloorDependOnTheSide) {
  Mesh mesh;
  As(&mesh, kGround)->AddQuad({0, 0, 0}, {2, 0, 1}, {2, 2, 1}, {0, 2, 0}, Material::kStone);
  As(&mesh, kGround)->AddQuad({3, 0, 0}, {3, 2, 0}, {3, 2, 1}, {3, 0, 1}, Material::kStone);
  const RayCaster caster(mesh);
  const auto seen = [&](const Eigen::Vector3f& from, const Eigen::Vector3f& along) {
    const Ray ray{from, along.normalized()};
    Hit hit;
    caster.Cast({&ray, 1}, 10, {&hit, 1});
    return hit.surface;
  };
  EXPECT_EQ(seen({1, 0.9f, 3}, {0, 0, -1}), kGround);
  EXPECT_EQ(seen({-2, 0.9f, 0.4f}, {1, 0, 0}), kGround);
  EXPECT_EQ(seen({1, 0.9f, -3}, {0, 0, 1}), kCeiling);
  EXPECT_EQ(seen({4, 0.9f, 0.4f}, {-1, 0, 0.1f}), kGround);  // A riser.
  EXPECT_EQ(seen({1, 0.9f, 3}, {0, 0, 1}), kUnknown);        // Nothing.
}

TEST(PointClasses, OfShapesAreThoseInForce) {
  Mesh mesh;
  {
    const As wall(&mesh, kWall);
    As(&mesh, kPole)->AddCylinder({0, 0, 0}, 0.1, 2, Material::kWood);
    EXPECT_EQ(std::ranges::count(mesh.classes, kPole), std::ssize(mesh.triangles));
    mesh.AddSlab({0, 0, 0}, {1, 1, 0.2}, 0, Material::kFloor, kGround);
    EXPECT_EQ(std::ranges::count(mesh.classes, kGround), 2);
    EXPECT_EQ(std::ranges::count(mesh.classes, kCeiling), 2);
    EXPECT_EQ(std::ranges::count(mesh.classes, kWall), 8);
    Random random(1, 2, 3);
    mesh.AddLeaves({0, 0, 2}, {1, 1, 1}, 7, random);
    EXPECT_EQ(std::ranges::count(mesh.classes, kVegetation), 7);
  }
  EXPECT_EQ(mesh.adds, kUnknown);
  Mesh both = mesh;
  both.Append(mesh, {5, 0, 0});
  ASSERT_EQ(both.classes.size(), both.triangles.size());
  for (size_t i = 0; i < mesh.classes.size(); ++i) {
    EXPECT_EQ(both.classes[mesh.classes.size() + i], mesh.classes[i]);
  }
}

TEST(PointClasses, AreKeptOnAnotherDay) {
  const World before = *MakeWorld("museum", 4);
  World after = before;
  Random random(1, 2, 3);
  ASSERT_TRUE(MoveFurniture(12, random, &after).ok());
  ASSERT_EQ(after.mesh.classes.size(), after.mesh.triangles.size());
  int moved = 0;
  for (size_t i = 0; i < after.mesh.triangles.size(); ++i) {
    if (after.mesh.triangles[i][0] < before.mesh.vertices.size()) continue;
    EXPECT_EQ(after.mesh.classes[i], kObject);
    ++moved;
  }
  EXPECT_GT(moved, 0);
  for (const PointClass stays : {kGround, kCeiling, kWall, kPole}) {
    EXPECT_EQ(std::ranges::count(after.mesh.classes, stays),
              std::ranges::count(before.mesh.classes, stays));
  }
}

}  // namespace
}  // namespace isthmus::simulation
