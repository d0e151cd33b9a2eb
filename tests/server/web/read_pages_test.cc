// Pages that are read from the map: the same bytes as the calls give that they stand for.
#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/floors/floors.h"
#include "core/floors/grid_map.h"
#include "core/formats/autoware.h"
#include "core/formats/tum.h"
#include "server/pipeline.h"
#include "server/web/web_server.h"
#include "storage/memory_store.h"
#include "tests/server/http/conversation.h"

namespace isthmus::web {
namespace {

class ReadPagesTest : public testing::Test {
 protected:
  ReadPagesTest() {
    server::PipelineOptions options;
    options.composition_interval_s = 0;
    pipeline_ = *server::Pipeline::Open(options, storage::MakeMemoryStore());
    rpc::ServerOptions rpc_options;
    rpc_options.listen = "127.0.0.1:0";
    server_ = *rpc::RpcServer::Start(pipeline_.get(), rpc_options);
    web_ = *WebServer::Start({.listen = "127.0.0.1:0"}, *server_, none_);
    address_ = web_->url().substr(std::string("http://").size());
  }

  SessionId Open(const std::string& robot) {
    return pipeline_->sessions().Create({.robot = RobotId(robot), .sensor = "vlp16"})->record.id;
  }
  // A sensor at 0.5 m that looks around itself.
  void Add(const SessionId& session, const std::string& robot, uint32_t index) {
    Submap submap;
    submap.id = {session, index};
    submap.robot = RobotId(robot);
    submap.T_odom_submap = Pose(Eigen::Vector3d(8. * index, 0, 0.5));
    submap.first_sequence = submap.last_sequence = index + 1;
    submap.first_stamp_ns = submap.last_stamp_ns = (index + 1) * int64_t{1'000'000'000};
    submap.keyframes.push_back({0, submap.first_stamp_ns, Pose()});
    std::uniform_real_distribution<float> place(-25, 25);
    for (int i = 0; i < 300; ++i) {
      submap.points.push_back({place(random_), place(random_), i % 3 == 0 ? 0.4f : -0.5f, 50, 0});
    }
    ASSERT_TRUE(pipeline_->sessions().AddSubmap(std::move(submap)).ok());
  }
  std::string Get(const std::string& target) const {
    const http::Reply reply = http::Ask(address_, "GET", target, "");
    EXPECT_EQ(reply.code, 200) << target << ": " << reply.body;
    return reply.body;
  }
  std::string Export(const ExportRequest& request) {
    std::string file;
    const absl::Status status = pipeline_->reader().ExportMap(
        request, [](int64_t) {},
        [&file](const std::string& piece) {
          file += piece;
          return true;
        });
    EXPECT_TRUE(status.ok()) << status;
    return file;
  }

  std::mt19937 random_{1};
  const Assets none_;
  std::unique_ptr<server::Pipeline> pipeline_;
  std::unique_ptr<rpc::RpcServer> server_;
  std::unique_ptr<WebServer> web_;
  std::string address_;
};

TEST_F(ReadPagesTest, CellsAreExportsOfTheirBoxes) {
  const SessionId alice = Open("alice");
  for (uint32_t i = 0; i < 4; ++i) Add(alice, "alice", i);
  pipeline_->WaitUntilIdle();
  const std::vector<TileInfo> tiles = pipeline_->reader().Map()->Tiles(0, 0);
  ASSERT_GT(tiles.size(), 8u);
  const std::string list = Get("/autoware/alice-1/pointcloud_map_metadata.yaml");
  std::vector<formats::CellCorner> corners;
  std::set<std::string> files;
  for (const TileInfo& tile : tiles) {
    const formats::CellCorner corner(20 * tile.id.x, 20 * tile.id.y);
    corners.push_back(corner);
    Box box;
    const auto before = [](int64_t edge) {
      return std::nextafter(static_cast<float>(edge), -1e9f);
    };
    box.min = Eigen::Vector3d(static_cast<double>(corner.first), static_cast<double>(corner.second),
                              -1e7);
    box.max = Eigen::Vector3d(before(corner.first + 20), before(corner.second + 20), 1e7);
    const std::string file =
        Get(absl::StrCat("/autoware/alice-1/pointcloud_map/", formats::CellFileName(corner)));
    EXPECT_EQ(file, Export({.format = ExportFormat::kPcdBinary, .box = box}));
    files.insert(file);
  }
  EXPECT_EQ(list, formats::FormatCellList(20, corners));
  EXPECT_EQ(files.size(), tiles.size());
}

TEST_F(ReadPagesTest, FloorsAreDrawnOfTheFreeSpace) {
  const SessionId alice = Open("alice");
  for (uint32_t i = 0; i < 4; ++i) Add(alice, "alice", i);
  pipeline_->WaitUntilIdle();
  const auto way = pipeline_->reader().GetTrajectory(RobotId("alice"), TrajectoryFrame::kMap);
  ASSERT_TRUE(way.ok()) << way.status();
  EXPECT_EQ(Get("/trajectories/alice-1.tum"), formats::FormatTum(way->poses));
  std::vector<Eigen::Vector3d> stations;
  floors::AddStations(way->poses, &stations);
  const floors::Floor floor = floors::FloorsOf(stations).front();
  const floors::HeightBand heights = floors::HeightsAround(floor);
  ExportRequest wanted{.format = ExportFormat::kOctoMapBinary, .resolution_m = 0.25};
  wanted.box = Box();
  wanted.box->min = Eigen::Vector3d(-1e7, -1e7, heights.lowest_m);
  wanted.box->max = Eigen::Vector3d(1e7, 1e7, heights.highest_m);
  const auto grid = floors::GridOf(Export(wanted), floor, std::nullopt);
  ASSERT_TRUE(grid.ok()) << grid.status();
  ASSERT_GT(grid->cells.size(), 1000u);
  EXPECT_EQ(Get("/floors/alice-1/floor_0.pgm?resolution=0.25"), floors::FormatPgm(*grid));
  EXPECT_EQ(Get("/floors/0/floor_0.yaml?resolution=0.25"),
            floors::FormatMapYaml(*grid, "floor_0.pgm"));
}

// No map server takes a map of no cells.
TEST_F(ReadPagesTest, ABoxThatHoldsNothingOfTheMapIsSaidToBeSo) {
  const SessionId alice = Open("alice");
  for (uint32_t i = 0; i < 2; ++i) Add(alice, "alice", i);
  pipeline_->WaitUntilIdle();
  for (const char* file : {"pgm", "yaml"}) {
    const std::string floor = absl::StrCat("/floors/0/floor_0.", file, "?resolution=0.25&box=");
    const http::Reply far = http::Ask(address_, "GET", floor + "1000,1000,0,1005,1005,3", "");
    EXPECT_EQ(far.code, 404) << far.body;
    EXPECT_NE(far.body.find("holds nothing of the map"), std::string::npos) << far.body;
    EXPECT_EQ(http::Ask(address_, "GET", floor + "-9,-9,-1,9,9,3", "").code, 200);
  }
}

// The gate looks at the request that is read, as it does at the same one over gRPC.
TEST_F(ReadPagesTest, TheGateSeesTheMapThatFloorsAreAskedOf) {
  const std::string target = absl::StrCat("/floors/", std::string(100, 'x'), "/floor_0.pgm");
  EXPECT_EQ(http::Ask(address_, "GET", target, "").code, 400);
}

}  // namespace
}  // namespace isthmus::web
