// Autoware's layout of the map over HTTP.
#include <absl/strings/str_cat.h>

#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/formats/map_writer.h"
#include "tests/server/web/web_fixture.h"

namespace isthmus::web {
namespace {

// Counts what is read of it.
class MapOfTiles final : public rpc::FakeMap {
 public:
  MapOfTiles() {
    components_ = 1;
    robots_ = {RobotId("alice")};
  }
  void Add(int32_t x, int32_t y, std::vector<MapPoint> points) { tiles_[{x, y}] = points; }
  double tile_m() const override { return tile_m_; }
  uint32_t tile_levels(uint32_t) const override { return 1; }
  std::vector<TileInfo> Tiles(uint32_t, uint32_t) const override {
    ++lists_;
    std::vector<TileInfo> infos;
    for (const auto& [place, points] : tiles_) infos.push_back(InfoOf(place, points));
    return infos;
  }
  absl::StatusOr<TileInfo> FindTile(const TileId& id) const override {
    const auto tile = tiles_.find({id.x, id.y});
    if (tile == tiles_.end()) return NoTile(id);
    return InfoOf(tile->first, tile->second);
  }
  absl::StatusOr<std::vector<MapPoint>> ReadTile(const TileId& id) const override {
    ++reads_;
    return tiles_.at({id.x, id.y});
  }
  absl::Status Read(const Region&, size_t, const Emit&) const override {
    return absl::InternalError("looks at every tile");
  }

  double tile_m_ = 200 * 0.1;  // Not 20 to the last digit.
  mutable std::atomic<int> lists_ = 0, reads_ = 0;

 private:
  using Place = std::pair<int32_t, int32_t>;
  static TileInfo InfoOf(const Place& place, const std::vector<MapPoint>& points) {
    TileInfo info;
    info.id = {0, 0, place.first, place.second};
    for (const MapPoint& p : points) info.bounds.Extend(Eigen::Vector3d(p.x, p.y, p.z));
    return info;
  }
  std::map<Place, std::vector<MapPoint>> tiles_;
};

MapPoint At(float x, float y, float z = 0) {
  MapPoint point;
  point.x = x;
  point.y = y;
  point.z = z;
  return point;
}

std::string FileOf(const std::vector<MapPoint>& points) {
  constexpr auto kEncoding = formats::PcdEncoding::kBinary;
  return formats::PcdMapHeader(points.size(), kEncoding, {RobotId("alice")}) +
         formats::PcdMapChunk(points, kEncoding);
}

class AutowareTest : public WebTest {
 protected:
  AutowareTest() {
    pipeline_.map = map_;
    map_->Add(-1, 0, {At(-3, 2)});
    map_->Add(0, 0, {At(4, 3)});
    map_->Add(0, 2, {At(5, 41)});
  }
  const std::shared_ptr<MapOfTiles> map_ = std::make_shared<MapOfTiles>();
};

TEST_F(AutowareTest, MetadataListsTilesAsCells) {
  Start();
  const http::Reply reply = Get("/autoware/0/pointcloud_map_metadata.yaml");
  ASSERT_EQ(reply.code, 200) << reply.body;
  EXPECT_EQ(reply.body,
            "x_resolution: 20.0\ny_resolution: 20.0\n-20_0.pcd: [-20, 0]\n0_0.pcd: [0, 0]\n"
            "0_40.pcd: [0, 40]\n");
}

TEST_F(AutowareTest, ParametersThatItDoesNotKnowAreRefused) {
  Start();
  EXPECT_EQ(Get("/autoware/0/pointcloud_map_metadata.yaml?site=default").code, 200);
  const http::Reply reply = Get("/autoware/0/pointcloud_map/-20_0.pcd?resolution=0.5");
  EXPECT_EQ(reply.code, 400);
  EXPECT_NE(reply.body.find("known here: site"), std::string::npos) << reply.body;
}

TEST_F(AutowareTest, ACellIsAFileToSave) {
  Start();
  const http::Reply reply = Get("/autoware/0/pointcloud_map/-20_0.pcd");
  ASSERT_EQ(reply.code, 200) << reply.body;
  EXPECT_TRUE(reply.is_whole);
  EXPECT_EQ(reply.headers.at("content-disposition"), "attachment; filename=\"-20_0.pcd\"");
  EXPECT_EQ(reply.headers.at("isthmus-revision"), "7");
  EXPECT_EQ(reply.body, FileOf({At(-3, 2)}));
}

// Neighbours share no point: coordinates are floats. Rounding may put a point on a tile beside the
// cell that it belongs to.
TEST_F(AutowareTest, ACellIsTheMapBetweenItsEdges) {
  const float before_20 = std::nextafter(20.f, 0.f), before_0 = -1e-30f;
  map_->Add(-1, 0, {At(-20, 0), At(before_0, before_20, 900), At(0, 5), At(-5, 20)});
  map_->Add(0, 0, {At(before_0, 7), At(before_20, 0, -900), At(20, 3)});
  map_->Add(1, 0, {At(20, before_20), At(before_20, 9)});
  Start();
  EXPECT_EQ(Get("/autoware/0/pointcloud_map/-20_0.pcd").body,
            FileOf({At(-20, 0), At(before_0, before_20, 900), At(before_0, 7)}));
  EXPECT_EQ(Get("/autoware/0/pointcloud_map/0_0.pcd").body,
            FileOf({At(0, 5), At(before_20, 0, -900), At(before_20, 9)}));
}

// Nobody lists the map for a cell: all of them together cost as many reads as there are tiles.
TEST_F(AutowareTest, ACellCostsItsOwnTile) {
  constexpr int kEdge = 12;
  for (int x = 0; x < kEdge; ++x) {
    for (int y = 0; y < kEdge; ++y) {
      map_->Add(x, y, {At(20.f * x + 9, 20.f * y + 9)});
    }
  }
  Start();
  for (int x = 0; x < kEdge; ++x) {
    for (int y = 0; y < kEdge; ++y) {
      const std::string name = absl::StrCat(20 * x, "_", 20 * y, ".pcd");
      EXPECT_EQ(Get("/autoware/0/pointcloud_map/" + name).code, 200) << name;
    }
  }
  EXPECT_EQ(map_->lists_, 0);
  EXPECT_EQ(map_->reads_, kEdge * kEdge);
}

TEST_F(AutowareTest, WhatIsAskedForIsChecked) {
  const std::string reader = NewToken("eve", AccessRole::kReader);
  Start();
  const std::string cookie = "Cookie: isthmus_token=" + reader + "\r\n";
  EXPECT_EQ(Get("/autoware/0/pointcloud_map_metadata.yaml").code, 401);
  EXPECT_EQ(Get("/autoware/0/pointcloud_map/0_0.pcd").code, 401);
  EXPECT_EQ(Get("/autoware/0/pointcloud_map_metadata.yaml", cookie).code, 200);
  for (const char* none :
       {"/autoware/", "/autoware/0", "/autoware/x/pointcloud_map_metadata.yaml",
        "/autoware/0/pointcloud_map/20_0.pcd", "/autoware/0/pointcloud_map/5_0.pcd",
        "/autoware/0/pointcloud_map/+0_0.pcd", "/autoware/0/pointcloud_map/0_0.ply",
        "/autoware/0/other/0_0.pcd"}) {
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
