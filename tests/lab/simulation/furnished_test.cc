// Furnished buildings: their content, the people who walk there, and the likeness of their twins.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "lab/simulation/sensors/ray_caster.h"
#include "lab/simulation/wild/furnish.h"
#include "lab/simulation/wild/plan.h"
#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/wild.h"

namespace isthmus::simulation::wild {
namespace {

// The least distance to anything in a level circle.
double NearestAround(const RayCaster& caster, const Eigen::Vector3d& at) {
  constexpr int kRays = 32;
  std::vector<Ray> rays;
  for (int i = 0; i < kRays; ++i) {
    const double angle = 2 * std::numbers::pi * i / kRays;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    rays.push_back({at.cast<float>(), out.cast<float>()});
  }
  std::vector<Hit> hits(rays.size());
  caster.Cast(rays, 5, hits);
  double nearest = 5;
  for (const Hit& hit : hits) {
    if (hit.range_m >= 0) nearest = std::min<double>(nearest, hit.range_m);
  }
  return nearest;
}

TEST(Floor, IsTakenPieceByPieceInsideAndBesideTheWay) {
  const auto way =
      std::make_shared<const Path>(Path::Along({{0, 2, 0}, {3, 2, 0}, {3, 4, 0}, {5, 4, 0}}, 0.4));
  constexpr double kClear = 0.5;
  Floor floor({0, 0}, {5, 6}, 0, kClear, Trodden({way}));
  Random random(5);
  struct Piece {
    Spot spot;
    Eigen::Vector2d size;
  };
  std::vector<Piece> pieces;
  for (int i = 0; i < 200; ++i) {
    const double wide = random.Uniform(0.2, 1.5);
    const Eigen::Vector2d size(wide, random.Uniform(0.2, 0.8));
    const auto spot =
        i % 2 == 0 ? floor.TakeAtWall(size, 0.05, random) : floor.TakeAnywhere(size, random);
    if (spot) pieces.push_back({*spot, size});
  }
  ASSERT_GT(pieces.size(), 15u);
  const auto covers = [](const Piece& piece, const Eigen::Vector2d& at) {
    const Eigen::Vector2d local =
        Eigen::Rotation2Dd(-piece.spot.yaw) * (at - piece.spot.foot.head<2>());
    return std::abs(local.x()) < piece.size.x() / 2 && std::abs(local.y()) < piece.size.y() / 2;
  };
  for (const Piece& piece : pieces) {  // Points all over each piece.
    for (double x = -0.49; x < 0.5; x += 0.07) {
      for (double y = -0.49; y < 0.5; y += 0.07) {
        const Eigen::Vector2d at =
            piece.spot.At(x * piece.size.x(), y * piece.size.y(), 0).head<2>();
        EXPECT_TRUE((at.array() > 0).all() && at.x() < 5 && at.y() < 6) << at.transpose();
        EXPECT_EQ(std::count_if(pieces.begin(), pieces.end(),
                                [&](const Piece& other) { return covers(other, at); }),
                  1);
        EXPECT_GT(PathIndex(*way).Distance(at, 2), kClear - 0.05);
      }
    }
  }
}

// A robot that drives long enough has been in every room of every storey, and nothing stood in the
// way.
TEST(Plan, EveryRoomIsReached) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    Random random(seed);
    Plan plan;
    plan.corridor_m = 1.6;
    plan.storey_m = 2.9;
    plan.storeys = 2;
    const Passage passage{0.5, 1};
    AddRow({false, 4, {{RoomUse::kLiving, 4}, {RoomUse::kBath, 2.2}, {RoomUse::kKitchen, 3.3}}},
           passage, random, &plan);
    AddRow({true, 6, {{RoomUse::kOpenPlan, 9}, {RoomUse::kStairs, 2.6}, {RoomUse::kStore, 3}}},
           passage, random, &plan);
    const auto corners = StrollThrough(plan, {0.6, plan.length_m - 0.6, 900, true, 0.1}, random);
    const auto way = std::make_shared<const Path>(Path::Along(corners, 0.4));
    Mesh mesh;
    AddPlanTo(plan, random, &mesh);
    const size_t bare = mesh.triangles.size();
    FurnishPlan(plan, {.world = seed, .day = seed}, 0.5, Trodden({way}), &mesh);
    EXPECT_GT(mesh.triangles.size(), bare + 2000);
    const RayCaster caster(mesh);
    std::vector<std::vector<bool>> been(plan.rooms.size(), std::vector<bool>(2));
    for (double s = 0; s < way->length(); s += 0.1) {
      const Eigen::Vector3d at = way->At(s).position;
      for (size_t i = 0; i < plan.rooms.size(); ++i) {
        const PlannedRoom& room = plan.rooms[i];
        const bool inside = ((at.head<2>() - room.min).array() > 0.5).all() &&
                            ((room.max - at.head<2>()).array() > 0.5).all();
        if (inside && at.z() < 0.3) been[i][0] = true;
        if (inside && at.z() > 2.6) been[i][1] = true;
      }
      for (const double above : {0.45, 0.9, 1.6}) {
        ASSERT_GT(NearestAround(caster, at + Eigen::Vector3d(0, 0, above)), 0.3)
            << seed << " at " << at.transpose();
      }
    }
    for (size_t i = 0; i < been.size(); ++i) {
      EXPECT_TRUE(been[i][0] && been[i][1]) << "room " << i << " of seed " << seed;
    }
  }
}

class FurnishedKind : public ::testing::TestWithParam<std::string> {};

std::unique_ptr<Simulator> Member(const std::string& kind, uint64_t seed, WildTwin twin, bool bare,
                                  int robot = 0) {
  WildTeam team{.kind = kind, .sensor = "vlp16", .robots = 2, .seconds = 10};
  team.twin = twin;
  team.bare = bare;
  team.first_day = true;
  return std::move(DrawWildTeamDrive(seed, team, robot)->simulator);
}

size_t Triangles(const Simulator& simulator) { return simulator.world().mesh.triangles.size(); }

TEST_P(FurnishedKind, HasTwinsOfThreeSorts) {
  constexpr uint64_t kSeed = 3;
  const auto own = Member(GetParam(), kSeed, WildTwin::kNone, false);
  const auto exact = Member(GetParam(), kSeed, WildTwin::kExact, false);
  const auto refurnished = Member(GetParam(), kSeed, WildTwin::kRefurnished, false);
  const auto bare = Member(GetParam(), kSeed, WildTwin::kNone, true);
  EXPECT_EQ(own->world().mesh.vertices, exact->world().mesh.vertices);
  EXPECT_NE(own->world().mesh.vertices, refurnished->world().mesh.vertices);
  EXPECT_GT(Triangles(*own), Triangles(*bare) + 500);
  // The walls are first: the twin has them in the same places.
  const auto& walls = bare->world().mesh.vertices;
  const auto& twins = refurnished->world().mesh.vertices;
  if (GetParam() != "carpark") {  // There each deck comes with its cars.
    EXPECT_TRUE(std::equal(walls.begin(), walls.end(), twins.begin()));
  }
  for (double t = 0; t < 10; t += 2) {
    EXPECT_EQ(own->PoseAt(0, t).Matrix(), refurnished->PoseAt(0, t).Matrix());
    EXPECT_EQ(own->PoseAt(0, t).Matrix(), bare->PoseAt(0, t).Matrix());
  }
}

TEST_P(FurnishedKind, RobotsGoWaysOfTheirOwn) {
  int apart = 0;
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const auto a = Member(GetParam(), seed, WildTwin::kNone, false, 0);
    const auto b = Member(GetParam(), seed, WildTwin::kNone, false, 1);
    EXPECT_EQ(a->world().mesh.vertices, b->world().mesh.vertices);
    apart += (a->PoseAt(0, 0).translation() - b->PoseAt(0, 0).translation()).norm() > 1;
  }
  EXPECT_GE(apart, 3);
}

TEST_P(FurnishedKind, PeopleWalkWhereNothingStands) {
  Scene (*make)(const Need&, Random&) = GetParam() == "flat"     ? MakeFlat
                                        : GetParam() == "office" ? MakeOffice
                                        : GetParam() == "storey" ? MakeStorey
                                        : GetParam() == "inn"    ? MakeInn
                                                                 : MakeCarPark;
  size_t people = 0;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    Need need;
    need.path_length_m = 40;
    need.seconds = 30;
    need.season = {.world = seed, .day = seed};
    const Scene scene = make(need, random);
    people += scene.walks.size();
    const RayCaster caster(scene.mesh);
    for (const Motion& walk : scene.walks) {
      double farthest = 0, path_length = 0;
      for (double t = 0; t < 60; t += 0.5) {
        const Eigen::Vector3d at = walk(t).translation(), next = walk(t + 0.5).translation();
        path_length += (next - at).norm();
        farthest = std::max(farthest, (at - walk(0).translation()).norm());
        EXPECT_LT((next - at).norm(), 0.5 * 1.6);
        ASSERT_GT(NearestAround(caster, at + Eigen::Vector3d(0, 0, 1.2)), 0.25)
            << GetParam() << " " << seed << " at " << at.transpose();
      }
      EXPECT_GT(path_length, 60 * 0.4);
      EXPECT_GT(farthest, 1.5);
    }
  }
  EXPECT_GT(people, 0u);
}

INSTANTIATE_TEST_SUITE_P(Wild, FurnishedKind, ::testing::ValuesIn(FurnishedKinds()),
                         [](const auto& kind) { return kind.param; });

// Extent of the floor in x and y.
Eigen::Vector2d Extent(const Mesh& mesh) {
  Eigen::Vector2f min = Eigen::Vector2f::Constant(std::numeric_limits<float>::max()), max = -min;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (mesh.materials[i] != Material::kFloor) continue;
    for (const uint32_t corner : mesh.triangles[i]) {
      min = min.cwiseMin(mesh.vertices[corner].head<2>());
      max = max.cwiseMax(mesh.vertices[corner].head<2>());
    }
  }
  return (max - min).cast<double>();
}

TEST(FurnishedKinds, AreAsLargeAsSuchPlacesAre) {
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    const double flat = Extent(Member("flat", seed, WildTwin::kNone, true)->world().mesh).prod();
    EXPECT_GT(flat, 38) << seed;
    EXPECT_LT(flat, 130) << seed;
    const double office =
        Extent(Member("office", seed, WildTwin::kNone, true)->world().mesh).prod();
    EXPECT_GT(office, 150) << seed;
    EXPECT_LT(office, 2200) << seed;
    const Eigen::Vector2d storey =
        Extent(Member("storey", seed, WildTwin::kNone, true)->world().mesh);
    EXPECT_NEAR(storey.x(), 41, 7) << seed;
    EXPECT_NEAR(storey.y(), 20, 3) << seed;
  }
}

}  // namespace
}  // namespace isthmus::simulation::wild
