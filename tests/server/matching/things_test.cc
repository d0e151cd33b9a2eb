#include "server/matching/prepared/things.h"

#include <gtest/gtest.h>

#include "server/matching/prepared/prepared_map.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

using Places = std::vector<Eigen::Vector2d>;

constexpr double kHalfX = 5, kHalfY = 3.5;

// A room of 10 by 7 m with a carton at each of the places.
Scene Room(const Places& cartons) {
  Scene scene;
  for (const double side : {-1.0, 1.0}) {
    scene.boxes.push_back({{side * (kHalfX + 0.1), 0, 1.3}, {0.1, kHalfY + 0.2, 1.3}});
    scene.boxes.push_back({{0, side * (kHalfY + 0.1), 1.3}, {kHalfX + 0.2, 0.1, 1.3}});
  }
  scene.boxes.push_back({{0, 0, -0.1}, {kHalfX, kHalfY, 0.1}});
  scene.boxes.push_back({{0, 0, 2.7}, {kHalfX, kHalfY, 0.1}});
  for (const Eigen::Vector2d& at : cartons) {
    scene.boxes.push_back({{at.x(), at.y(), 0.5}, {0.3, 0.3, 0.5}, 0.4});
  }
  return scene;
}

Places Furniture() { return {{-4, -2.3}, {-2, 2.4}, {0.5, -2.4}, {2.2, 2.2}, {4, -1.6}, {4, 2.5}}; }
Places OtherFurniture() {
  return {{-4, 1.5}, {-2.6, -2.4}, {-0.6, 2.4}, {2, -2.3}, {3.6, 0.6}, {0.7, 2.3}};
}

// The map of a robot that drives up and down the room, or back.
SessionMap DriveIn(const Scene& room, bool back, unsigned seed) {
  const double way = back ? -3.2 : 3.2;
  Drive drive{Way({{-way, -0.4, 0.8}, {way, -0.4, 0.8}, {way, 0.4, 0.8}, {-way, 0.4, 0.8}}, 30),
              Pose::FromXyzRpy(back ? 1 : 0, 0.5, 0.8, 0, 0, back ? 2 : 0)};
  drive.seed = seed;
  drive.azimuths = 720;
  return Survey(room, drive);
}

ThingAgreement Compare(const Scene& room, const Scene& other_room) {
  const SessionMap map_a = DriveIn(room, false, 1), map_b = DriveIn(other_room, true, 2);
  const PreparedMap a(map_a), b(map_b);
  const Pose T_world_a = Pose::FromXyzRpy(0, 0.5, 0.8, 0, 0, 0);
  const Pose T_world_b = Pose::FromXyzRpy(1, 0.5, 0.8, 0, 0, 2);
  const MapPoses poses = MapPoses::Rigid(map_a, map_b, T_world_a.Inverse() * T_world_b);
  ThingAgreement sum;
  for (size_t k = 0; k < poses.a.size(); ++k) {
    sum += a.things().In(b.things(), k, poses.a[k], poses.b);
  }
  return sum;
}

TEST(ThingsTest, AreThereWhereTheyStoodBefore) {
  const ThingAgreement same = Compare(Room(Furniture()), Room(Furniture()));
  EXPECT_GE(same.there, 3);
  EXPECT_EQ(same.gone, 0);
}

TEST(ThingsTest, AreGoneInARoomThatIsFurnishedDifferently) {
  const ThingAgreement other = Compare(Room(Furniture()), Room(OtherFurniture()));
  EXPECT_GE(other.gone, 3);
  EXPECT_LE(other.there, 1);
  EXPECT_GE(Compare(Room(Furniture()), Room({})).gone, 3);
}

TEST(ThingsTest, WallsAreNone) {
  const ThingAgreement bare = Compare(Room({}), Room({}));
  EXPECT_EQ(bare.there, 0);
  EXPECT_EQ(bare.gone, 0);
}

// Submaps that come later bring theirs, and those of the first ones stay.
TEST(ThingsTest, GrowWithTheMap) {
  const SessionMap whole = DriveIn(Room(Furniture()), false, 1);
  SessionMap first = whole;
  first.submaps.resize(whole.submaps.size() / 2);
  const PreparedMap at_once(whole), half(first);
  const Things grown(half.things(), whole, at_once.submaps(), at_once.T_level_odom());
  const MapPoses poses = MapPoses::Rigid(whole, whole, Pose());
  const MapPoses of_half = MapPoses::Rigid(first, whole, Pose());
  for (size_t k = 0; k < whole.submaps.size(); ++k) {
    const ThingAgreement in_whole = grown.In(at_once.things(), k, poses.a[k], poses.b);
    EXPECT_EQ(in_whole.gone, 0) << k;
    if (k < first.submaps.size()) {
      const ThingAgreement before = half.things().In(at_once.things(), k, of_half.a[k], poses.b);
      EXPECT_GT(in_whole.there, 0) << k;
      EXPECT_LE(in_whole.there, before.there) << "later views may look through some, " << k;
    }
  }
  const ThingAgreement last = grown.In(grown, whole.submaps.size() - 1, poses.a.back(), poses.b);
  const ThingAgreement at_once_last =
      at_once.things().In(at_once.things(), whole.submaps.size() - 1, poses.a.back(), poses.b);
  EXPECT_NEAR(static_cast<double>(last.there), static_cast<double>(at_once_last.there), 3);
}

}  // namespace
}  // namespace isthmus::matching
