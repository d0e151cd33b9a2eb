// Autoware's layout of the map over HTTP.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/web/web_fixture.h"

namespace isthmus::web {
namespace {

class ThreeTilesMap final : public rpc::FakeMap {
 public:
  ThreeTilesMap() { components_ = 1; }
  double tile_m() const override { return tile_m_; }
  uint32_t tile_levels(uint32_t) const override { return 1; }
  std::vector<TileInfo> Tiles(uint32_t component, uint32_t) const override {
    std::vector<TileInfo> tiles(3);
    tiles[0].id = {component, 0, -1, 0};
    tiles[1].id = {component, 0, 0, 0};
    tiles[2].id = {component, 0, 0, 2};
    return tiles;
  }
  double tile_m_ = 200 * 0.1;  // Not 20 to the last digit.
};

class AutowareTest : public WebTest {
 protected:
  AutowareTest() {
    pipeline_.map = map_;
    pipeline_.file = {"a cell"};
  }
  const std::shared_ptr<ThreeTilesMap> map_ = std::make_shared<ThreeTilesMap>();
};

TEST_F(AutowareTest, MetadataListsTilesAsCells) {
  Start();
  const http::Reply reply = Get("/autoware/0/pointcloud_map_metadata.yaml");
  ASSERT_EQ(reply.code, 200) << reply.body;
  EXPECT_EQ(reply.body,
            "x_resolution: 20.0\ny_resolution: 20.0\n-20_0.pcd: [-20, 0]\n0_0.pcd: [0, 0]\n"
            "0_40.pcd: [0, 40]\n");
}

// Neighbours share no point: coordinates are floats.
TEST_F(AutowareTest, ACellIsTheMapBetweenItsEdges) {
  Start();
  const http::Reply reply = Get("/autoware/0/pointcloud_map/-20_0.pcd");
  ASSERT_EQ(reply.code, 200) << reply.body;
  EXPECT_EQ(reply.body, "a cell");
  EXPECT_TRUE(reply.is_whole);
  EXPECT_EQ(reply.headers.at("content-disposition"), "attachment; filename=\"-20_0.pcd\"");
  ASSERT_EQ(pipeline_.exports.size(), 1u);
  EXPECT_EQ(pipeline_.exports[0].format, ExportFormat::kPcdBinary);
  const Box& box = *pipeline_.exports[0].box;
  EXPECT_EQ(box.min.x(), -20);
  EXPECT_LT(box.max.x(), 0);
  EXPECT_GT(box.max.x(), -1e-30);
  EXPECT_EQ(box.min.y(), 0);
  EXPECT_LT(box.max.y(), 20);
  EXPECT_EQ(static_cast<float>(box.max.y()), std::nextafter(20.f, 0.f));
  EXPECT_LT(box.min.z(), -1e6);
}

TEST_F(AutowareTest, WhatIsAskedForIsChecked) {
  const std::string reader = NewToken("eve", AccessRole::kReader);
  Start();
  const std::string cookie = "Cookie: isthmus_token=" + reader + "\r\n";
  EXPECT_EQ(Get("/autoware/0/pointcloud_map_metadata.yaml").code, 401);
  EXPECT_EQ(Get("/autoware/0/pointcloud_map/0_0.pcd").code, 401);
  EXPECT_EQ(Get("/autoware/0/pointcloud_map_metadata.yaml", cookie).code, 200);
  for (const char* none : {"/autoware/", "/autoware/0", "/autoware/x/pointcloud_map_metadata.yaml",
                           "/autoware/0/pointcloud_map/20_0.pcd",
                           "/autoware/0/pointcloud_map/0_0.ply", "/autoware/0/other/0_0.pcd"}) {
    EXPECT_EQ(Get(none, cookie).code, 404) << none;
  }
  EXPECT_EQ(http::Ask(address_, "POST", "/autoware/0/pointcloud_map_metadata.yaml", cookie).code,
            405);
  map_->tile_m_ = 12.5;
  const http::Reply odd = Get("/autoware/0/pointcloud_map_metadata.yaml", cookie);
  EXPECT_EQ(odd.code, 400);
  EXPECT_NE(odd.body.find("composition.tile_m"), std::string::npos) << odd.body;
}

}  // namespace
}  // namespace isthmus::web
