// Rooms and doors of drawn floors.
#include "core/floors/rooms.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "tests/core/floors/drawn_floor.h"

namespace isthmus::floors {
namespace {

Rooms Find(const DrawnFloor& floor) {
  const auto found = RoomsOf(floor.map());
  EXPECT_TRUE(found.ok()) << found.status();
  return found.ok() ? *found : Rooms();
}

int32_t RoomAt(const DrawnFloor& floor, const Rooms& found, double x, double y) {
  const Eigen::Vector2d at = (floor.InMap(x, y) - floor.map().origin) / floor.map().resolution_m;
  return found.labels[static_cast<size_t>(static_cast<int64_t>(at.y()) * floor.map().width +
                                          static_cast<int64_t>(at.x()))];
}

// Two rooms of 4 x 3 m and 3 x 3 m; the door of 0.9 m between them is at x = 5.08, y = 2.
void DrawTwoRooms(DrawnFloor* floor) {
  floor->Room(1, 1, 5, 4);
  floor->Room(5.15, 1, 8.15, 4);
  floor->Free(4.9, 1.55, 5.2, 2.45);
}

// A corridor of 12 x 1.6 m below four rooms of 2.9 x 4 m.
void DrawCorridor(DrawnFloor* floor) {
  for (int i = 0; i < 4; ++i) floor->Room(3 + 3.05 * i, 5, 5.9 + 3.05 * i, 9);
  floor->Room(3, 3.25, 15.05, 4.85);
  for (int i = 0; i < 4; ++i) floor->Free(3.5 + 3.05 * i, 4.8, 4.4 + 3.05 * i, 5.1);
}

void ExpectOneOfArea(const Rooms& found, double area_m2) {
  ASSERT_EQ(found.rooms.size(), 1u);
  EXPECT_NEAR(found.rooms[0].area_m2, area_m2, 0.02 * area_m2);
  EXPECT_TRUE(found.doors.empty());
}

TEST(RoomsOf, TwoRoomsHaveADoor) {
  DrawnFloor floor(9, 5);
  DrawTwoRooms(&floor);
  const Rooms found = Find(floor);
  ASSERT_EQ(found.rooms.size(), 2u);
  EXPECT_NEAR(found.rooms[0].area_m2, 12, 0.2);
  EXPECT_NEAR(found.rooms[1].area_m2, 9, 0.2);
  EXPECT_FALSE(found.rooms[0].is_corridor);
  ASSERT_EQ(found.doors.size(), 1u);
  const Door& door = found.doors[0];
  EXPECT_EQ(door.rooms, (std::array<int32_t, 2>{0, 1}));
  EXPECT_NEAR(door.width_m, 0.9, 0.1);
  EXPECT_LT(((door.ends[0] + door.ends[1]) / 2 - floor.InMap(5.08, 2)).norm(), 0.2);
  for (size_t i = 0; i < 2; ++i) {
    const Room& room = found.rooms[i];
    const Eigen::Vector2d at = (room.inside - floor.map().origin) / floor.map().resolution_m;
    EXPECT_EQ(found.labels[static_cast<size_t>(static_cast<int64_t>(at.y()) * floor.map().width +
                                               static_cast<int64_t>(at.x()))],
              static_cast<int32_t>(i));
    EXPECT_TRUE(room.holes.empty());
    const double m2 = SignedArea(room.outline);
    EXPECT_NEAR(m2, room.area_m2, 0.05 * room.area_m2);
    EXPECT_LE(room.outline.size(), 10u);
  }
}

TEST(RoomsOf, ACorridorJoinsItsRooms) {
  for (const double yaw : {0.0, std::numbers::pi / 6}) {
    DrawnFloor floor(18, 18, yaw);
    DrawCorridor(&floor);
    const Rooms found = Find(floor);
    ASSERT_EQ(found.rooms.size(), 5u) << yaw;
    EXPECT_EQ(found.doors.size(), 4u) << yaw;
    const int32_t corridor = RoomAt(floor, found, 9, 4);
    ASSERT_GE(corridor, 0);
    EXPECT_NEAR(found.rooms[static_cast<size_t>(corridor)].area_m2, 12.05 * 1.6, 0.7) << yaw;
    for (size_t i = 0; i < 5; ++i) {
      EXPECT_EQ(found.rooms[i].is_corridor, static_cast<int32_t>(i) == corridor) << yaw;
    }
    for (int i = 0; i < 4; ++i) {
      const int32_t room = RoomAt(floor, found, 4 + 3.05 * i, 7);
      ASSERT_GE(room, 0);
      EXPECT_NEAR(found.rooms[static_cast<size_t>(room)].area_m2, 11.6, 0.3) << yaw;
    }
  }
}

TEST(RoomsOf, FurnitureDoesNotPartARoom) {
  DrawnFloor floor(18, 18);
  DrawCorridor(&floor);
  floor.Put(3.8, 6.5, 4.8, 7.1);   // A table.
  floor.Put(6.05, 6.6, 7.4, 7.2);  // A cupboard at a wall, and a bed at the other.
  floor.Put(8, 7, 8.95, 9);
  for (int i = 0; i < 4; ++i) floor.Put(9.6 + 0.5 * i, 7, 9.7 + 0.5 * i, 7.1);  // Legs of chairs.
  floor.Put(12.15, 8.3, 15.05, 9);  // Shelves along a wall.
  const Rooms found = Find(floor);
  EXPECT_EQ(found.rooms.size(), 5u);
  EXPECT_EQ(found.doors.size(), 4u);
  EXPECT_EQ(RoomAt(floor, found, 7, 5.5), RoomAt(floor, found, 7, 8.5));
}

// As thick as furniture, but on both sides of the door alike.
TEST(RoomsOf, AThickWallPartsRooms) {
  for (const double yaw : {0.0, 0.4}) {
    DrawnFloor floor(14, 10, yaw);
    floor.Room(3, 3, 11, 7);
    floor.Put(6.7, 3, 7.25, 7);
    floor.Free(6.6, 4.5, 7.35, 5.4);
    const Rooms found = Find(floor);
    EXPECT_EQ(found.rooms.size(), 2u) << yaw;
    EXPECT_EQ(found.doors.size(), 1u) << yaw;
  }
}

TEST(RoomsOf, AnLShapedRoomIsOne) {
  DrawnFloor floor(10, 10);
  floor.Room(1, 1, 9, 4.5);
  floor.Room(1, 1, 4.5, 9);
  floor.Free(1, 1, 9, 4.5);
  ExpectOneOfArea(Find(floor), 8 * 3.5 + 3.5 * 4.5);
}

TEST(RoomsOf, AnOpenPlanIsOne) {
  DrawnFloor floor(22, 16);
  floor.Room(1, 1, 21, 15);
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 2; ++y) floor.Put(5 + 5 * x, 5 + 5 * y, 5.4 + 5 * x, 5.4 + 5 * y);
  }
  ExpectOneOfArea(Find(floor), 20 * 14);
}

TEST(RoomsOf, NothingIsFoundOfNothing) {
  const Rooms unknown = Find(DrawnFloor(5, 5));
  EXPECT_TRUE(unknown.rooms.empty());
  EXPECT_EQ(unknown.labels, std::vector<int32_t>(10'000, -1));
  EXPECT_TRUE(Find(DrawnFloor(0, 0)).rooms.empty());
  DrawnFloor cupboard(5, 5);
  cupboard.Room(2, 2, 3, 3);
  EXPECT_TRUE(Find(cupboard).rooms.empty()) << "too small for a room";
  DrawnFloor free(5, 5);
  free.Free(0, 0, 5, 5);
  ExpectOneOfArea(Find(free), 25);
}

TEST(RoomsOf, NoiseDoesNotPartRooms) {
  DrawnFloor floor(18, 18);
  DrawCorridor(&floor);
  std::mt19937 random(3);
  for (GridCell& cell : floor.map().cells) {
    if (random() % 100 == 0) cell = random() % 2 == 0 ? GridCell::kUnknown : GridCell::kOccupied;
  }
  const Rooms found = Find(floor);
  EXPECT_EQ(found.rooms.size(), 5u);
  EXPECT_EQ(found.doors.size(), 4u);
}

// Cells at random are what parts ground into most pieces.
TEST(RoomsOf, LargeMapsAreBounded) {
  GridMap map{.resolution_m = 0.05, .width = 4000, .height = 4000, .cells = {}};
  std::mt19937 random(4);
  for (int64_t i = 0; i < map.width * map.height; ++i) {
    map.cells.push_back(random() % 3 == 0 ? GridCell::kOccupied : GridCell::kFree);
  }
  EXPECT_TRUE(RoomsOf(map).ok());
  map.width *= 4;
  map.cells.resize(map.cells.size() * 4, GridCell::kFree);
  const absl::Status status = RoomsOf(map).status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
}

}  // namespace
}  // namespace isthmus::floors
