// The files that exports make, over a socket, read by other readers than wrote them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "client/offline/embedded_server.h"
#include "core/codec/payload_layout.h"
#include "core/formats/cloud_file.h"
#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

// One server with one robot for all tests.
class ExportCommandsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new std::string(ScratchFolder());
    const ProgramResult simulated =
        Isthmus("simulate --world museum --robots 1 --seconds 4 --seed 1 -o " + *folder_);
    ASSERT_EQ(simulated.code, 0) << simulated.err;
    server::PipelineOptions options;
    options.composition_interval_s = 0;
    auto server = EmbeddedServer::Start(options);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = server->release();
    ASSERT_EQ(Ask("push --robot alice " + Path("robot_0")).code, 0);
    ASSERT_NE(Ask("status --wait settled --timeout 60").code, 4);
  }
  static void TearDownTestSuite() {
    delete server_;
    fs::remove_all(*folder_);
    delete folder_;
  }

  static std::string Path(const std::string& name) { return *folder_ + "/" + name; }
  static ProgramResult Ask(const std::string& command) {
    return Isthmus(command + " --server " + server_->client().address());
  }
  static json AskJson(const std::string& command) {
    const ProgramResult result = Ask(command + " --json");
    EXPECT_EQ(result.code, 0) << result.err;
    return json::parse(result.out, nullptr, false);
  }

  static EmbeddedServer* server_;
  static std::string* folder_;
};

EmbeddedServer* ExportCommandsTest::server_ = nullptr;
std::string* ExportCommandsTest::folder_ = nullptr;

// Points of a PLY file, by its header.
int PointsOfPly(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line) && line != "end_header";) {
    if (line.starts_with("element vertex ")) return std::stoi(line.substr(15));
  }
  return -1;
}

TEST_F(ExportCommandsTest, OfSeveralMapsItSaysWhichOne) {
  const std::string drive = Path("elsewhere");
  ASSERT_EQ(Isthmus("simulate --world campus --robots 1 --seconds 4 --seed 2 -o " + drive).code, 0);
  server::PipelineOptions options;
  options.composition_interval_s = 0;
  auto server = EmbeddedServer::Start(options);
  ASSERT_TRUE(server.ok()) << server.status();
  const auto ask = [&server](const std::string& command) {
    return Isthmus(command + " --server " + (*server)->client().address());
  };
  ASSERT_EQ(ask("push --robot bob " + Path("robot_0")).code, 0);
  ASSERT_NE(ask("status --wait settled --timeout 60").code, 4);
  EXPECT_EQ(ask("export -o " + Path("one.pcd")).err, "");
  ASSERT_EQ(ask("push --robot alice " + drive + "/robot_0").code, 0);
  ASSERT_NE(ask("status --wait settled --timeout 60").code, 4);

  for (const char* command : {"export -o ", "query -o ", "picture -o ", "graph --g2o "}) {
    const bool is_picture = std::string(command).starts_with("picture");
    const bool is_graph = std::string(command).starts_with("graph");
    const std::string file = Path(is_picture ? "two.png" : is_graph ? "two.g2o" : "two.pcd");
    const ProgramResult result = ask(std::string(command) + file);
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("map 0 is that of bob-1, one of 2")) << command;
  }
  EXPECT_EQ(ask("export --map alice-1 -o " + Path("named.pcd")).err, "");
  for (const char* format : {"query --robot alice -o two.pcd", "export --robot alice -o two.pcd",
                             "export --robot alice -o two.bt"}) {
    const ProgramResult refused = ask(format);
    EXPECT_EQ(refused.code, 3) << format << refused.err;
    EXPECT_THAT(refused.err, HasSubstr("ask for the map alice-1")) << format;
  }
  EXPECT_EQ(ask("export --box 0,0,0,1,1,1 -o " + Path("two.geojson")).code, 2);
  EXPECT_EQ(ask("query --robot alice --map alice-1 -o " + Path("alice.pcd")).code, 0);
}

TEST_F(ExportCommandsTest, WhatWasDroppedIsAFileOfItsOwn) {
  const ProgramResult none = Ask("export --format ply --dynamic -o " + Path("none.ply"));
  EXPECT_EQ(none.code, 3);
  EXPECT_THAT(none.err, HasSubstr("composition.drop_gone"));
  EXPECT_EQ(Ask("export --format las --dynamic -o " + Path("none.las")).code, 2);

  const std::string drive = Path("busy");
  ASSERT_EQ(
      Isthmus("simulate --world museum --robots 1 --walkers 60 --seconds 12 -o " + drive).code, 0);
  server::PipelineOptions options;
  options.composition_interval_s = 0;
  options.composer.drop_gone = true;
  auto server = EmbeddedServer::Start(options);
  ASSERT_TRUE(server.ok()) << server.status();
  const auto ask = [&](const std::string& command) {
    return Isthmus(command + " --server " + (*server)->client().address()).code;
  };
  ASSERT_EQ(ask("push --robot alice " + drive + "/robot_0"), 0);
  ASSERT_NE(ask("status --wait settled --timeout 60"), 4);
  ASSERT_EQ(ask("export --format ply --dynamic -o " + Path("gone.ply")), 0);
  ASSERT_EQ(ask("export --format ply -o " + Path("kept.ply")), 0);
  EXPECT_GT(PointsOfPly(Path("gone.ply")), 20);
  EXPECT_LT(PointsOfPly(Path("gone.ply")), PointsOfPly(Path("kept.ply")) / 5);
}

TEST_F(ExportCommandsTest, ClassesMakeUpTheMap) {
  const auto points_of = [](const std::string& name) {
    return static_cast<int>(formats::ReadCloudFile(Path(name))->width);
  };
  ASSERT_EQ(Ask("export --format ply -o " + Path("all.ply")).code, 0);
  ASSERT_EQ(Ask("export --class ground,wall -o " + Path("walls.pcd")).code, 0);
  ASSERT_EQ(Ask("export --format las --class ceiling,pole,vegetation,vehicle,object,structure,"
                "mover,unknown -o " +
                Path("rest.las"))
                .code,
            0);
  EXPECT_GT(points_of("walls.pcd"), 1000);
  EXPECT_EQ(points_of("walls.pcd") + points_of("rest.las"), points_of("all.ply"));
  ASSERT_EQ(Ask("query --class ground --class wall -o " + Path("asked.pcd")).code, 0);
  EXPECT_EQ(points_of("asked.pcd"), points_of("walls.pcd"));
  const auto cloud = formats::ReadCloudFile(Path("walls.pcd"));
  const PointField* label = codec::FindField(*cloud, {"label"});
  ASSERT_NE(label, nullptr);
  for (const double of : codec::ReadColumn(*cloud, *label)) ASSERT_TRUE(of == 1 || of == 3) << of;
  const ProgramResult wrong = Ask("export --class walls -o " + Path("wrong.pcd"));
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("choose one of unknown, ground"));
  EXPECT_EQ(Ask("export --class wall -o " + Path("wrong.bt")).code, 2);
}

TEST_F(ExportCommandsTest, FilesGoToStandardOutputWholeAndAlone) {
  // Not by the names of devices: a program that replaces them would do so to this machine.
  for (const char* name : {"-", "/dev/fd/1"}) {
    const ProgramResult ply = Ask("export --format ply -o " + std::string(name));
    EXPECT_EQ(ply.code, 0) << ply.err;
    EXPECT_TRUE(ply.out.starts_with("ply\n"));
    ASSERT_EQ(Ask("export --format ply -o " + Path("whole.ply")).code, 0);
    EXPECT_EQ(ply.out.size(), fs::file_size(Path("whole.ply"))) << name;
    EXPECT_TRUE(Ask("trajectory alice -o " + std::string(name)).out.starts_with("# stamp"));
    EXPECT_TRUE(Ask("graph --g2o " + std::string(name)).out.starts_with("#"));
  }
}

TEST_F(ExportCommandsTest, ExportsOpenInOtherPrograms) {
  const auto las = AskJson("export --format las --robot alice -o " + Path("map.las"));
  const auto cloud = formats::ReadCloudFile(Path("map.las"));
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(las["points"], cloud->width);
  ASSERT_EQ(Ask("export --format ply --robot alice -o " + Path("map.ply")).code, 0);
  EXPECT_EQ(formats::ReadCloudFile(Path("map.ply"))->width, cloud->width);
  ASSERT_EQ(Ask("export --format ply --robot alice --min-z 0 -o " + Path("high.ply")).code, 0);
  EXPECT_LT(formats::ReadCloudFile(Path("high.ply"))->width, cloud->width);
  EXPECT_EQ(Ask("export --format las --robot nobody -o " + Path("never.las")).code, 6);
  EXPECT_FALSE(fs::exists(Path("never.las")));
  EXPECT_EQ(Ask("export --format las -o -").out.substr(0, 4), "LASF");
  EXPECT_TRUE(Ask("export --format mcap -o -").out.starts_with("\x89MCAP0"));
  ASSERT_EQ(Ask("trajectory alice --format kitti -o " + Path("poses.txt")).code, 0);
  const std::string tum = Ask("trajectory alice -o -").out;
  EXPECT_EQ(Ask("trajectory alice-1 -o -").out, tum) << "a session may be named";
  EXPECT_EQ(Ask("trajectory alice-2 -o -").code, 6);
  std::ifstream poses(Path("poses.txt"));
  double first = 0;
  EXPECT_TRUE(poses >> first) << "numbers";
}

TEST_F(ExportCommandsTest, GridMapsAndTilesAreSeveralFiles) {
  const json maps =
      AskJson("export --format nav2 --robot alice --resolution 0.1 -o " + Path("hall.pgm"));
  ASSERT_EQ(maps["maps"].size(), 1u) << maps;
  EXPECT_EQ(maps["maps"][0]["file"], Path("hall_floor0.yaml"));
  EXPECT_GT(maps["maps"][0]["occupied"], 100);
  EXPECT_GT(maps["maps"][0]["free"], maps["maps"][0]["occupied"]);
  EXPECT_TRUE(fs::exists(Path("hall_floor0.pgm")));
  json kinds;
  std::ifstream rooms(Path("hall_floor0_rooms.geojson"));
  const json found = json::parse(rooms);
  for (const json& feature : found["features"]) {
    kinds.push_back(feature["properties"]["kind"]);
  }
  EXPECT_EQ(std::count(kinds.begin(), kinds.end(), "door"), maps["maps"][0]["doors"]);
  EXPECT_EQ(kinds.size(),
            maps["maps"][0]["rooms"].get<size_t>() + maps["maps"][0]["doors"].get<size_t>());
  EXPECT_GT(maps["maps"][0]["rooms"], 0);
  ASSERT_EQ(Ask("export --format nav2 --robot alice --resolution 0.1 --height-band 0 0.5 -o " +
                Path("band"))
                .code,
            0);
  EXPECT_TRUE(fs::exists(Path("band.yaml")) && fs::exists(Path("band.pgm")));
  EXPECT_TRUE(fs::exists(Path("band_rooms.geojson")));
  EXPECT_EQ(Ask("export --format nav2 -o -").code, 2);
  EXPECT_EQ(Ask("export --format nav2 --height-band 1 0 -o " + Path("no")).code, 2);
  // Nor is there a map without cells, which no map server takes.
  for (const char* nothing :
       {"nav2 --box 1000,1000,0,1005,1005,3", "nav2 --box -5,-5,90,5,5,99",
        "nav2 --height-band 90 91", "autoware --box 1000,1000,0,1005,1005,3"}) {
    const ProgramResult far = Ask(std::string("export -o ") + Path("far") + " --format " + nothing);
    EXPECT_EQ(far.code, 6) << nothing << far.out;
    EXPECT_THAT(far.err, HasSubstr("nothing of the map")) << nothing;
  }
  for (const auto& file : fs::directory_iterator(Path(""))) {
    EXPECT_THAT(file.path().filename().string(), testing::Not(testing::StartsWith("far")));
  }
  const json tiles = AskJson("export --format autoware --robot alice --tile 10 -o " + Path("site"));
  uint64_t points = 0, files = 0;
  for (const auto& file : fs::directory_iterator(Path("site/pointcloud_map"))) {
    const auto tile = formats::ReadCloudFile(file.path());
    ASSERT_TRUE(tile.ok()) << tile.status();
    points += tile->width;
    ++files;
  }
  EXPECT_EQ(tiles["points"], points);
  EXPECT_EQ(tiles["files"], files);
  EXPECT_TRUE(fs::exists(Path("site/pointcloud_map_metadata.yaml")));
  EXPECT_EQ(Ask("export --format autoware -o " + Path("site")).code, 5) << "it is there already";
}

TEST_F(ExportCommandsTest, ADatumPutsTheMapOnTheEarth) {
  EXPECT_EQ(Ask("export --format kml -o " + Path("no.kml")).code, 3) << "there is no datum";
  EXPECT_EQ(Ask("anchor set alice --lat 48 --lon 11 --alt 0 --sigma-xy 1").code, 3);
  EXPECT_EQ(Ask("anchor set alice --sigma-xy 1").code, 2);
  EXPECT_EQ(Ask("datum set --lat 91 --lon 11 --alt 0").code, 2);
  ASSERT_EQ(Ask("datum set --lat 48.137 --lon 11.575 --alt 520").code, 0);
  EXPECT_EQ(AskJson("datum show")["datum"]["altitude_m"], 520);
  const json anchored = AskJson(
      "anchor set alice-1/0 --lat 48.1379 --lon 11.575 --alt 521 --sigma-xy 0.02 --sigma-z "
      "0.02");
  EXPECT_EQ(anchored["session"], "alice-1");
  const json anchors = AskJson("anchor list")["anchors"];
  ASSERT_EQ(anchors.size(), 1u);
  const auto& at = anchors[0]["t_map_submap"]["translation"];
  EXPECT_NEAR(at["x"].get<double>(), 0, 0.01);
  EXPECT_NEAR(at["y"].get<double>(), 100.07, 0.05) << "0.0009 degrees north";
  EXPECT_NEAR(at["z"].get<double>(), 1, 0.01);
  const json las = AskJson("export --format las -o " + Path("geo.las"));
  EXPECT_EQ(las["system"], "WGS 84 / UTM zone 32N");
  const json ways = json::parse(Ask("export --format geojson -o -").out);
  const json& first = ways["features"][0]["geometry"]["coordinates"][0];
  EXPECT_NEAR(first[0].get<double>(), 11.575, 1e-5);
  EXPECT_NEAR(first[1].get<double>(), 48.1379, 1e-5);
  ASSERT_EQ(Ask("anchor remove alice-1/0").code, 0);
  EXPECT_EQ(AskJson("datum clear")["datum"], nullptr);
}

}  // namespace
}  // namespace isthmus::cli
