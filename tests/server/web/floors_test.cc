// Floors and ways as files over HTTP, and what vehicles are told of the map.
#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "core/formats/tum.h"
#include "tests/server/web/web_fixture.h"

namespace isthmus::web {
namespace {

// A floor of 4 x 2 m at z = 0 with a wall across it at x = 3, free above.
std::string FloorWithWall() {
  octomap::OcTree tree(0.1);
  for (double x = 0.05; x < 4; x += 0.1) {
    for (double y = 0.05; y < 2; y += 0.1) {
      for (double z = -0.05; z < 1; z += 0.1) {
        const bool is_occupied = z < 0 || (x > 3 && x < 3.1);
        tree.setNodeValue(x, y, z, is_occupied ? 2.0F : -2.0F, true);
      }
    }
  }
  tree.updateInnerOccupancy();
  std::ostringstream file;
  tree.writeBinary(file);
  return file.str();
}

class FloorsTest : public WebTest {
 protected:
  FloorsTest() {
    EXPECT_TRUE(pipeline_.sessions().Create({.robot = RobotId("alice")}).ok());
    RobotTrajectory way;
    way.session = SessionId("alice-1");
    way.component = 0;
    for (int i = 0; i < 8; ++i) {
      way.poses.push_back(
          {int64_t{1'000'000'000} * (i + 1), Pose(Eigen::Vector3d(0.3 + 0.5 * i, 1, 0.5))});
    }
    way.parts = {{1, way.poses.size()}};
    pipeline_.trajectory = way;
    Component component;
    component.reference = way.session;
    component.sessions = {way.session};
    pipeline_.info.components = {component};
    pipeline_.file = {FloorWithWall()};
  }
};

TEST_F(FloorsTest, AreListed) {
  Start();
  const http::Reply reply = Get("/floors/0");
  ASSERT_EQ(reply.code, 200) << reply.body;
  const auto list = nlohmann::json::parse(reply.body);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0]["yaml"], "floor_0.yaml");
  EXPECT_EQ(list[0]["pgm"], "floor_0.pgm");
  EXPECT_EQ(list[0]["rooms"], "floor_0.rooms.json");
  EXPECT_EQ(list[0]["lowest_m"], 0.5);
  EXPECT_EQ(Get("/floors/1").code, 404) << "there is no such component";
}

// As map_server puts the two together: row by row from the top, the origin at the lower left.
TEST_F(FloorsTest, AreDrawnAsMapServersReadThem) {
  Start();
  const http::Reply yaml = Get("/floors/0/floor_0.yaml?resolution=0.1");
  ASSERT_EQ(yaml.code, 200) << yaml.body;
  EXPECT_NE(yaml.body.find("image: \"floor_0.pgm\""), std::string::npos) << yaml.body;
  EXPECT_NE(yaml.body.find("resolution: 0.1\norigin: [0, 0, 0]"), std::string::npos) << yaml.body;
  const http::Reply pgm = Get("/floors/0/floor_0.pgm?resolution=0.1");
  ASSERT_EQ(pgm.code, 200);
  ASSERT_TRUE(pgm.is_whole);
  const size_t pixels = pgm.body.find("255\n") + 4;
  ASSERT_EQ(pgm.body.size() - pixels, 40u * 20u);
  for (size_t i = 0; i < 40 * 20; ++i) {
    const auto pixel = static_cast<unsigned char>(pgm.body[pixels + i]);
    EXPECT_EQ(pixel, i % 40 == 30 ? 0 : 254) << i;
  }
  EXPECT_EQ(Get("/floors/0/floor_0.yaml?resolution=0").code, 200);
  EXPECT_EQ(pipeline_.exports.back().resolution_m, 0.05);
  pipeline_.exports.pop_back();
  // Only what lies around the floor was asked of the map.
  ASSERT_EQ(pipeline_.exports.size(), 2u);
  EXPECT_EQ(pipeline_.exports[0].format, ExportFormat::kOctoMapBinary);
  EXPECT_EQ(pipeline_.exports[0].resolution_m, 0.1);
  EXPECT_GT(pipeline_.exports[0].box->min.z(), -3);
  EXPECT_LT(pipeline_.exports[0].box->max.z(), 1);
}

// The wall leaves 3 x 2 m on one side, and less than 2 m2 on the other.
TEST_F(FloorsTest, TheirRoomsAreGeoJson) {
  Start();
  const http::Reply reply = Get("/floors/0/floor_0.rooms.json?resolution=0.1");
  ASSERT_EQ(reply.code, 200) << reply.body;
  const auto file = nlohmann::json::parse(reply.body);
  EXPECT_EQ(file["frame"], "map");
  ASSERT_EQ(file["features"].size(), 2u) << reply.body;
  EXPECT_EQ(file["features"][0]["properties"]["kind"], "room");
  EXPECT_NEAR(file["features"][0]["properties"]["area_m2"].get<double>(), 6, 0.01);
  EXPECT_NEAR(file["features"][1]["properties"]["area_m2"].get<double>(), 1.8, 0.01);
  EXPECT_EQ(file["features"][0]["geometry"]["coordinates"][0].front(),
            file["features"][0]["geometry"]["coordinates"][0].back());
  EXPECT_EQ(Get("/floors/0/floor_1.rooms.json").code, 404);
}

TEST_F(FloorsTest, WhatIsAskedForIsChecked) {
  const std::string reader = NewToken("eve", AccessRole::kReader);
  Start();
  const std::string cookie = "Cookie: isthmus_token=" + reader + "\r\n";
  EXPECT_EQ(Get("/floors/0").code, 401);
  EXPECT_EQ(Get("/floors/0/floor_0.pgm").code, 401);
  EXPECT_EQ(Get("/floors/0/floor_0.rooms.json").code, 401);
  EXPECT_EQ(Get("/floors/0", cookie).code, 200);
  for (const char* none :
       {"/floors/", "/floors/x", "/floors/0/floor_1.pgm", "/floors/0/floor_0",
        "/floors/0/floor_-1.yaml", "/floors/0/0/floor_0.yaml", "/floors/0/floor_0.json"}) {
    EXPECT_EQ(Get(none, cookie).code, 404) << none;
  }
  EXPECT_EQ(Get("/floors/0/floor_0.pgm?resolution=x", cookie).code, 400);
  EXPECT_EQ(Get("/floors/0/floor_0.pgm?box=1,2", cookie).code, 400);
  EXPECT_EQ(Get("/floors/0/floor_0.pgm?box=0,0,50,1,1,60", cookie).code, 404) << "above the floor";
  const http::Reply turned = Get("/floors/0/floor_0.pgm?box=5,5,5,-5,-5,-5", cookie);
  EXPECT_EQ(turned.code, 400);
  EXPECT_NE(turned.body.find("exchange them"), std::string::npos) << turned.body;
  for (const char* leaf : {"1e-9", "-1", "nan", "11"}) {
    const http::Reply reply = Get(std::string("/floors/0/floor_0.yaml?resolution=") + leaf, cookie);
    EXPECT_EQ(reply.code, 400) << leaf;
    EXPECT_NE(reply.body.find("give 0.01 to 10 m"), std::string::npos) << reply.body;
  }
  EXPECT_EQ(http::Ask(address_, "POST", "/floors/0", cookie).code, 405);
}

TEST_F(FloorsTest, WhatIsTooLargeIsRefused) {
  pipeline_.file = {std::string(17 << 20, 'a')};
  Start();
  const http::Reply reply = Get("/floors/0/floor_0.pgm");
  EXPECT_EQ(reply.code, 429);
  EXPECT_NE(reply.body.find("resolution"), std::string::npos) << reply.body;
}

TEST_F(FloorsTest, WaysAreTextOfTum) {
  const std::string reader = NewToken("eve", AccessRole::kReader);
  Start();
  const std::string cookie = "Cookie: isthmus_token=" + reader + "\r\n";
  const http::Reply way = Get("/trajectories/alice-1.tum", cookie);
  ASSERT_EQ(way.code, 200) << way.body;
  EXPECT_NE(way.body.find("\n1.000000000 0.3 1 0.5 0 0 0 1\n"), std::string::npos) << way.body;
  const auto poses = formats::ParseTum(way.body);
  ASSERT_TRUE(poses.ok()) << poses.status();
  EXPECT_EQ(poses->size(), 8u);
  EXPECT_EQ(Get("/trajectories/alice-1.tum?frame=odom", cookie).code, 200);
  EXPECT_EQ(Get("/trajectories/alice-1.tum?frame=x", cookie).code, 400);
  EXPECT_EQ(Get("/trajectories/alice-1.tum?frames=odom", cookie).code, 400);
  EXPECT_EQ(Get("/trajectories/alice-1.tum").code, 401);
  EXPECT_EQ(Get("/trajectories/.tum", cookie).code, 404);
  EXPECT_EQ(Get("/trajectories/alice-1", cookie).code, 404);
  pipeline_.trajectory = absl::NotFoundError("no such robot");
  EXPECT_EQ(Get("/trajectories/zoe.tum", cookie).code, 404);
}

TEST_F(FloorsTest, WaysLieOnTheEarth) {
  const std::string reader = NewToken("eve", AccessRole::kReader);
  Start();
  const std::string cookie = "Cookie: isthmus_token=" + reader + "\r\n";
  const http::Reply nowhere = Get("/trajectories.geojson", cookie);
  EXPECT_EQ(nowhere.code, 400);
  EXPECT_NE(nowhere.body.find("isthmus datum set"), std::string::npos) << nowhere.body;
  pipeline_.info.datum = Datum{.latitude_deg = 47, .longitude_deg = 8};
  const http::Reply ways = Get("/trajectories.geojson?component=0", cookie);
  ASSERT_EQ(ways.code, 200) << ways.body;
  const auto file = nlohmann::json::parse(ways.body);
  ASSERT_EQ(file["features"].size(), 1u);
  EXPECT_EQ(file["features"][0]["properties"]["robot"], "alice");
  EXPECT_EQ(file["features"][0]["geometry"]["coordinates"].size(), 8u);
  EXPECT_NEAR(file["features"][0]["geometry"]["coordinates"][0][1].get<double>(), 47, 1e-4);
  EXPECT_EQ(Get("/trajectories.geojson?component=1", cookie).code, 404);
  EXPECT_EQ(Get("/trajectories.geojson?component=x", cookie).code, 404);
  EXPECT_EQ(Get("/trajectories.geojson?map=alice-1", cookie).code, 200);
  EXPECT_EQ(Get("/trajectories.geojson?robot=alice", cookie).code, 400);
  EXPECT_EQ(Get("/trajectories.geojson").code, 401);
}

// More sessions take number 0, and no name.
TEST_F(FloorsTest, AreOfTheMapThatIsNamed) {
  Component forged, alice;
  forged.reference = SessionId("mallory-1");
  for (int i = 1; i <= 8; ++i) forged.sessions.emplace_back("mallory-" + std::to_string(i));
  alice.component = 1;
  alice.reference = SessionId("alice-1");
  alice.sessions = {SessionId("alice-1")};
  pipeline_.info.components = {forged, alice};
  pipeline_.trajectory->component = 1;
  pipeline_.map->components_ = 2;
  pipeline_.map->places_ = {{SessionId("mallory-1"), 0}, {SessionId("alice-1"), 1}};
  Start();
  EXPECT_EQ(Get("/floors/alice-1").code, 200);
  EXPECT_EQ(Get("/floors/0").code, 404) << "no honest robot is there";
  ASSERT_EQ(Get("/floors/alice-1/floor_0.pgm").code, 200);
  EXPECT_EQ(pipeline_.exports.back().component, MapName(SessionId("alice-1")));
  const http::Reply reply = Get("/vda5050/alice-1/map.pcd");
  ASSERT_EQ(reply.code, 200) << reply.body;
  EXPECT_NE(reply.body.find("map.pcd?map=alice-1&revision="), std::string::npos) << reply.body;
  const http::Reply deleted = Get("/floors/carol-1");
  EXPECT_EQ(deleted.code, 404);
  EXPECT_NE(deleted.body.find("isthmus status"), std::string::npos) << deleted.body;
  EXPECT_EQ(Get("/tiles/carol-1/0/0/0.pts").code, 404);
  EXPECT_EQ(Get("/autoware/carol-1/pointcloud_map_metadata.yaml").code, 404);
}

// The link that a vehicle is given is the file of that revision or nothing.
TEST_F(FloorsTest, VehiclesAreToldWhereToDownloadTheMap) {
  Component component;
  component.reference = SessionId("alice-1");
  pipeline_.info.components = {component};
  pipeline_.map->components_ = 1;
  pipeline_.map->places_ = {{SessionId("alice-1"), 0}};
  {
    MutexLock lock(&pipeline_.load_mutex);
    pipeline_.load.revision = 7;
  }
  Start();
  const http::Reply reply = Get("/vda5050/0/map.pcd?resolution=0.1&box=-5,-5,0,5,5.25,3");
  ASSERT_EQ(reply.code, 200) << reply.body;
  const auto action = nlohmann::json::parse(reply.body);
  EXPECT_EQ(action["actionType"], "downloadMap");
  std::map<std::string, std::string> parameters;
  for (const auto& any : action["actionParameters"]) parameters[any["key"]] = any["value"];
  EXPECT_EQ(parameters["mapId"], "alice-1");
  const std::string& link = parameters["mapDownloadLink"];
  const std::string here = "http://" + address_;
  ASSERT_EQ(link.substr(0, here.size()), here);
  const http::Reply file = Get(link.substr(here.size()));
  EXPECT_EQ(file.code, 200) << file.body;
  ASSERT_EQ(pipeline_.exports.size(), 1u);
  EXPECT_EQ(pipeline_.exports[0].resolution_m, 0.1);
  EXPECT_EQ(pipeline_.exports[0].box->max, Eigen::Vector3d(5, 5.25, 3));
  EXPECT_EQ(parameters["mapVersion"], "7");
  const http::Reply other = Get("/export/map.pcd?revision=6");
  EXPECT_EQ(other.code, 409) << "the map has changed";
  EXPECT_NE(other.body.find("revision 7"), std::string::npos) << other.body;
  EXPECT_EQ(Get("/export/map.pcd?revision=x").code, 400);
  // Submaps of revision 7 come into a later map, which has the same number.
  {
    MutexLock lock(&pipeline_.load_mutex);
    pipeline_.load.composition_waits = true;
  }
  const http::Reply partial = Get("/export/map.pcd?revision=7");
  EXPECT_EQ(partial.code, 503) << partial.body;
  EXPECT_NE(partial.body.find("ask again"), std::string::npos) << partial.body;
  EXPECT_EQ(Get("/export/map.pcd").code, 200) << "whatever there is";
  // Taken for a filter, they would give the whole map for a part.
  EXPECT_EQ(Get("/export/map.pcd?robot=alice").code, 400);
  EXPECT_EQ(Get("/export/map.pcd?resolution=0.1&resolution=0.2").code, 400);
  EXPECT_EQ(Get("/vda5050/0/map.pcd?robot=alice").code, 400);
  EXPECT_EQ(Get("/export/map.pcd?site=default").code, 200);
  EXPECT_EQ(Get("/vda5050/1/map.pcd").code, 404);
  EXPECT_EQ(Get("/vda5050/0/map.las").code, 404);
  EXPECT_EQ(Get("/vda5050/0").code, 404);
  // Else the vehicle would be sent to a file that it cannot get.
  for (const char* bad :
       {"map.pcd?resolution=x", "map.pcd?resolution=nan", "map.pcd?resolution=-1",
        "map.bt?resolution=0.001", "map.pcd?box=5,5,5,-5,-5,-5", "map.pcd?box=0,0,0,1,1,inf"}) {
    EXPECT_EQ(Get(std::string("/vda5050/0/") + bad).code, 400) << bad;
    EXPECT_EQ(Get(std::string("/export/") + bad).code, 400) << bad;
  }
}

}  // namespace
}  // namespace isthmus::web
