// Tiles over HTTP: their points, and what is not sent twice.
#include <absl/strings/str_cat.h>

#include <memory>

#include "core/codec/tile_points.h"
#include "tests/server/web/web_fixture.h"

namespace isthmus::web {
namespace {

using testing::StartsWith;

// One tile, of two robots of three.
class OneTileMap final : public rpc::FakeMap {
 public:
  OneTileMap() {
    robots_ = {RobotId("alice"), RobotId("b\xc3\xb6rje"), RobotId("carol")};
    components_ = 1;
    point_.robot = 1;
    point_.x = -3.5f;
  }
  uint32_t tile_levels(uint32_t) const override { return 2; }
  absl::StatusOr<TileInfo> FindTile(const TileId& tile) const override {
    if (tile.component != 0 || tile.level != 1 || tile.x != -2 || tile.y != 3) return NoTile(tile);
    TileInfo info;
    info.id = tile;
    info.version = version_;
    info.points = 1;
    return info;
  }
  absl::StatusOr<std::vector<MapPoint>> ReadTile(const TileId&) const override {
    return std::vector<MapPoint>{point_};
  }

  uint64_t version_ = 0xabc;

 private:
  MapPoint point_;
};

class TilesTest : public WebTest {
 protected:
  TilesTest() { pipeline_.map = map_; }
  const std::shared_ptr<OneTileMap> map_ = std::make_shared<OneTileMap>();
};

TEST_F(TilesTest, ATileComesWithItsVersionAndTheNamesOfItsRobots) {
  Start();
  const http::Reply tile = Get("/tiles/0/1/-2/3.pts");
  ASSERT_EQ(tile.code, 200) << tile.body;
  EXPECT_TRUE(tile.is_whole);
  EXPECT_EQ(tile.headers.at("etag"), "\"0000000000000abc\"");
  EXPECT_EQ(tile.headers.at("isthmus-revision"), "7");
  EXPECT_EQ(tile.headers.at("isthmus-robots"), "[\"b\\u00f6rje\"]");
  EXPECT_EQ(tile.headers.at("cache-control"), "private, no-cache");
  EXPECT_THAT(tile.body, StartsWith("PTS2"));
  const auto points = codec::ReadTilePoints(tile.body);
  ASSERT_TRUE(points.ok()) << points.status();
  ASSERT_EQ(points->size(), 1u);
  EXPECT_EQ((*points)[0].robot, 0u);  // Index into the names that came along.
  EXPECT_FLOAT_EQ((*points)[0].x, -3.5f);
}

TEST_F(TilesTest, WhoHasTheVersionHearsThatNothingHasChanged) {
  Start();
  for (const char* has : {"\"0000000000000abc\"", "W/\"0000000000000abc\""}) {
    const http::Reply same =
        Get("/tiles/0/1/-2/3.pts", absl::StrCat("If-None-Match: ", has, "\r\n"));
    EXPECT_EQ(same.code, 304) << has;
    EXPECT_EQ(same.body, "");
    EXPECT_EQ(same.headers.at("etag"), "\"0000000000000abc\"");
  }
  for (const char* other : {"\"0000000000000abd\"", "*", "\"\"", "\"xyz\"", "0000000000000abc"}) {
    EXPECT_EQ(Get("/tiles/0/1/-2/3.pts", absl::StrCat("If-None-Match: ", other, "\r\n")).code, 200)
        << other;
  }
  map_->version_ = 0xdef;
  const http::Reply changed = Get("/tiles/0/1/-2/3.pts", "If-None-Match: \"0000000000000abc\"\r\n");
  EXPECT_EQ(changed.code, 200);
  EXPECT_EQ(changed.headers.at("etag"), "\"0000000000000def\"");
}

TEST_F(TilesTest, WhatIsNoTileIsNotThere) {
  const std::string reader = NewToken("eve", AccessRole::kReader);
  Start();
  EXPECT_EQ(Get("/tiles/0/1/-2/3.pts").code, 401);
  const std::string token = Bearer(reader);
  EXPECT_EQ(Get("/tiles/0/1/-2/3.pts", token).code, 200);
  for (const char* path :
       {"/tiles/0/1/-2/4.pts", "/tiles/1/1/-2/3.pts", "/tiles/0/9/-2/3.pts", "/tiles/0/1/-2/3",
        "/tiles/0/1/-2.pts", "/tiles/0/1/-2/3/4.pts", "/tiles/0/1/x/3.pts", "/tiles/-1/1/-2/3.pts",
        "/tiles/0/1/99999999999/3.pts", "/tiles/", "/tiles/0/1/-2/../3.pts"}) {
    EXPECT_EQ(Get(path, token).code, 404) << path;
  }
  EXPECT_EQ(Get("/tiles/0/1/-2/3.pts?site=yard", token).code, 403);
  EXPECT_EQ(Get("/tiles/0/1/-2/3.pts?robot=alice", token).code, 400);
  EXPECT_EQ(http::Ask(address_, "POST", "/tiles/0/1/-2/3.pts", token).code, 405);
}

}  // namespace
}  // namespace isthmus::web
