// Rooms and doors as GeoJSON.
#include "core/floors/rooms_file.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/core/floors/drawn_floor.h"

namespace isthmus::floors {
namespace {

using nlohmann::json;

TEST(FormatRooms, PolygonsAreRoomsAndLinesAreDoors) {
  Rooms found;
  found.rooms = {
      {.area_m2 = 4.00049, .inside = {1, 1}, .outline = {{0, 0}, {2, 0}, {2, 2}, {0, 2}}},
      {.is_corridor = true,
       .area_m2 = 96,
       .inside = {7, 5},
       .outline = {{2, 0}, {12, 0}, {12, 10}, {2, 10}},
       .holes = {{{4, 4}, {4, 6}, {6, 6}, {6, 4}}}}};
  found.doors = {{{Eigen::Vector2d(2, 0.5), Eigen::Vector2d(2, 1.4)}, 0.9, {0, 1}}};
  const std::string text = FormatRooms(found);
  EXPECT_EQ(text.back(), '\n');
  const json file = json::parse(text);
  EXPECT_EQ(file["type"], "FeatureCollection");
  EXPECT_EQ(file["frame"], "map");
  const json& features = file["features"];
  ASSERT_EQ(features.size(), 3u);
  EXPECT_EQ(features[0]["properties"], json::parse(R"({"kind": "room", "id": 0, "area_m2": 4.0,
                                                       "inside": [1.0, 1.0]})"));
  EXPECT_EQ(features[0]["geometry"], json::parse(R"({"type": "Polygon", "coordinates":
      [[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 0.0]]]})"));
  EXPECT_EQ(features[1]["properties"]["kind"], "corridor");
  EXPECT_EQ(features[1]["geometry"]["coordinates"].size(), 2u);
  EXPECT_EQ(features[2]["properties"],
            json::parse(R"({"kind": "door", "width_m": 0.9, "rooms": [0, 1]})"));
  EXPECT_EQ(features[2]["geometry"],
            json::parse(R"({"type": "LineString", "coordinates": [[2.0, 0.5], [2.0, 1.4]]})"));
}

TEST(FormatRooms, NoRoomsAreAFileToo) {
  EXPECT_EQ(json::parse(FormatRooms({}))["features"], json::array());
}

// A corridor round a room: its ring has a hole, and no place is in both.
TEST(FormatRooms, ACorridorGoesRoundARoom) {
  DrawnFloor floor(14, 14);
  floor.Room(1, 1, 13, 13);
  floor.Room(4, 4, 10, 10);
  floor.Free(6.5, 9.9, 7.4, 10.2);
  const auto found = RoomsOf(floor.map());
  ASSERT_TRUE(found.ok()) << found.status();
  const json file = json::parse(FormatRooms(*found));
  ASSERT_EQ(file["features"].size(), 3u) << file;
  const json& corridor = file["features"][0];
  EXPECT_EQ(corridor["geometry"]["coordinates"].size(), 2u) << corridor;
  EXPECT_EQ(file["features"][1]["properties"]["kind"], "room");
  EXPECT_EQ(file["features"][2]["properties"]["kind"], "door");
}

}  // namespace
}  // namespace isthmus::floors
