// Tiles, regions and the watch of the map over a socket, with the client library: whatever a reader
// asks for is what the whole map holds, at one revision.
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <thread>
#include <tuple>

#include "client/library/client.h"
#include "client/library/map_mirror.h"
#include "core/codec/tile_points.h"
#include "storage/memory_store.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus::rpc {
namespace {

using client::Client;
using client::MapMirror;

// All that is said of a point, the robot by its name.
using NamedPoint = std::tuple<float, float, float, float, std::string, uint32_t>;

std::vector<NamedPoint> Named(const std::vector<RobotId>& robots,
                              const std::vector<MapPoint>& points) {
  std::vector<NamedPoint> named;
  for (const MapPoint& p : points) {
    named.emplace_back(p.x, p.y, p.z, p.intensity, robots.at(p.robot).value(), p.stamp);
  }
  std::sort(named.begin(), named.end());
  return named;
}

class MapReadingTest : public testing::Test {
 protected:
  static constexpr int64_t kFirstSecond = 1'700'000'000;

  MapReadingTest() {
    server::PipelineOptions options;
    options.composition_interval_s = 0;
    pipeline_ = *server::Pipeline::Open(options, storage::MakeMemoryStore());
    ServerOptions listen;
    listen.listen = "127.0.0.1:0";
    server_ = *RpcServer::Start(pipeline_.get(), listen);
    client_ = *Client::Connect({.address = server_->address()});
    stubs_ = std::make_unique<Stubs>(
        grpc::CreateChannel(server_->address(), grpc::InsecureChannelCredentials()));
  }

  SessionId Open(const std::string& robot) {
    const auto session = pipeline_->sessions().Create({.robot = RobotId(robot), .sensor = "vlp16"});
    EXPECT_TRUE(session.ok()) << session.status();
    return session->record.id;
  }
  // So few points that nobody looks for matches, over some tiles.
  void Add(const SessionId& session, const std::string& robot, uint32_t index, int count = 30) {
    Submap submap;
    submap.id = {session, index};
    submap.robot = RobotId(robot);
    submap.T_odom_submap = Pose(Eigen::Vector3d(10.0 * index, 0, 0));
    submap.first_sequence = submap.last_sequence = index + 1;
    submap.first_stamp_ns = submap.last_stamp_ns = (kFirstSecond + index) * 1'000'000'000;
    submap.keyframes.push_back({0, submap.first_stamp_ns, Pose()});
    std::uniform_real_distribution<float> place(-40, 40);
    for (int i = 0; i < count; ++i) {
      submap.points.push_back({place(random_), place(random_), place(random_) / 10, 50, 0});
    }
    const auto added = pipeline_->sessions().AddSubmap(std::move(submap));
    ASSERT_TRUE(added.ok()) << added.status();
  }
  RegionChunk Query(const RegionQuery& query) {
    RegionChunk all;
    const absl::Status status = client_->QueryRegion(query, [&](const RegionChunk& chunk) {
      all.revision = chunk.revision;
      all.robots = chunk.robots;
      all.resolution_m = chunk.resolution_m;
      all.next = chunk.next;
      all.points.insert(all.points.end(), chunk.points.begin(), chunk.points.end());
      return true;
    });
    EXPECT_TRUE(status.ok()) << status;
    return all;
  }
  RegionChunk Everything(uint32_t component = 0) {
    return Query({.component = component, .wants_stamp = true});
  }
  // Two robots, known apart.
  void Fill() {
    const SessionId alice = Open("alice");
    for (uint32_t i = 0; i < 3; ++i) Add(alice, "alice", i);
    const SessionId bob = Open("bob");
    Add(bob, "bob", 0, 20);
    pipeline_->WaitUntilIdle();
  }

  std::mt19937 random_{1};
  std::unique_ptr<server::Pipeline> pipeline_;
  std::unique_ptr<RpcServer> server_;
  std::unique_ptr<Client> client_;
  std::unique_ptr<Stubs> stubs_;
};

TEST_F(MapReadingTest, TilesMakeUpTheMap) {
  Fill();
  for (uint32_t component = 0; component < 2; ++component) {
    const RegionChunk all = Everything(component);
    const auto list = client_->ListTiles(component);
    ASSERT_TRUE(list.ok()) << list.status();
    EXPECT_EQ(list->tile_m, 20);
    EXPECT_EQ(list->revision, all.revision);
    std::vector<NamedPoint> of_tiles;
    for (const TileInfo& info : list->tiles) {
      const auto tile = client_->GetTile(info.id);
      ASSERT_TRUE(tile.ok()) << tile.status();
      EXPECT_EQ(tile->info.version, info.version);
      EXPECT_EQ(tile->points.size(), info.points);
      for (const MapPoint& p : tile->points) {
        EXPECT_EQ(std::floor(p.x / 20), info.id.x);
        EXPECT_EQ(std::floor(p.y / 20), info.id.y);
      }
      const auto points = Named(tile->robots, tile->points);
      of_tiles.insert(of_tiles.end(), points.begin(), points.end());
      const auto again = client_->GetTile(info.id, info.version);
      EXPECT_TRUE(again->not_modified);
      EXPECT_TRUE(again->points.empty());
      EXPECT_FALSE(client_->GetTile(info.id, info.version + 1)->not_modified);
    }
    std::sort(of_tiles.begin(), of_tiles.end());
    EXPECT_EQ(of_tiles, Named(all.robots, all.points));
    EXPECT_FALSE(of_tiles.empty());
  }
}

TEST_F(MapReadingTest, TilesForBrowsersHoldTheSamePoints) {
  Fill();
  const auto list = client_->ListTiles(0);
  for (const TileInfo& info : list->tiles) {
    v1::GetTileRequest request;
    request.mutable_id()->set_x(info.id.x);
    request.mutable_id()->set_y(info.id.y);
    v1::GetTileResponse whole;
    ASSERT_GRPC_OK(Merged(stubs_->map->GetTile(NewContext().get(), request), &whole));
    EXPECT_THAT(whole.robots(), testing::ElementsAre("alice"));
    const auto points = codec::ReadTilePoints(whole.points());
    ASSERT_TRUE(points.ok()) << points.status();
    const auto exact = client_->GetTile(info.id);
    ASSERT_EQ(points->size(), exact->points.size());
    for (size_t i = 0; i < points->size(); ++i) {
      EXPECT_NEAR((*points)[i].x, exact->points[i].x, 2e-4);
      EXPECT_NEAR((*points)[i].z, exact->points[i].z, 2e-4);
      EXPECT_EQ((*points)[i].stamp, exact->points[i].stamp);
    }
  }
}

TEST_F(MapReadingTest, WhatIsNotThereIsSaidSo) {
  Fill();
  EXPECT_TRUE(absl::IsNotFound(client_->GetTile({0, 0, 1000, 0}).status()));
  EXPECT_TRUE(absl::IsNotFound(client_->GetTile({7, 0, 0, 0}).status()));
  EXPECT_TRUE(absl::IsNotFound(client_->GetTile({0, 29, 0, 0}).status()));
  EXPECT_TRUE(absl::IsNotFound(client_->ListTiles(7).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(client_->ListTiles(0, 29).status()));
  std::vector<v1::GetTileResponse> none;
  EXPECT_GRPC_ERROR(ReadAll(stubs_->map->GetTile(NewContext().get(), {}), &none), INVALID_ARGUMENT,
                    "name a tile");
}

TEST_F(MapReadingTest, RegionsAreWhatTheWholeMapHoldsThere) {
  Fill();
  const RegionChunk all = Everything();
  const auto expect = [&](const RegionQuery& query, const auto& keep) {
    std::vector<MapPoint> expected;
    for (const MapPoint& p : all.points) {
      if (keep(p)) expected.push_back(p);
    }
    EXPECT_FALSE(expected.empty());
    EXPECT_LT(expected.size(), all.points.size());
    RegionQuery asked = query;
    asked.wants_stamp = true;
    EXPECT_EQ(Named(all.robots, Query(asked).points), Named(all.robots, expected));
  };
  const auto in = [](const RegionShape& shape) {
    return [solid = MakeShape(shape)](const MapPoint& p) {
      return solid->Contains(Eigen::Vector3d(p.x, p.y, p.z));
    };
  };
  const RegionShape shapes[] = {OrientedBox{Pose::FromXyzRpy(5, 3, 0, 0.1, 0, 0.6), {40, 30, 5}},
                                Polygon{{{-30, -30}, {40, -10}, {0, 35}}, {-2, 3}},
                                Corridor{{{-40, -20, 0}, {10, 0, 1}, {40, 30, 0}}, 20, {}}};
  for (const RegionShape& shape : shapes) expect({.shape = shape}, in(shape));
  expect({.seen_from_ns = (kFirstSecond + 1) * 1'000'000'000},
         [](const MapPoint& p) { return p.stamp >= kFirstSecond + 1; });
  expect({.seen_to_ns = kFirstSecond * 1'000'000'000 + 5},
         [](const MapPoint& p) { return p.stamp <= kFirstSecond; });
  const absl::Status never =
      client_->QueryRegion({.seen_from_ns = 2, .seen_to_ns = 1}, [](const auto&) { return true; });
  EXPECT_TRUE(absl::IsInvalidArgument(never)) << never;
}

TEST_F(MapReadingTest, SessionsAreToldApart) {
  const SessionId first = Open("alice");
  Add(first, "alice", 0);
  ASSERT_TRUE(pipeline_->sessions().Finish(first).ok());
  pipeline_->WaitUntilIdle();
  const uint32_t component = *client_->GetSession(first)->component;
  const RegionChunk all = Everything(component);
  EXPECT_EQ(Query({.component = component, .sessions = {first}}).points.size(), all.points.size());
  const SessionId second = Open("bob");
  EXPECT_TRUE(Query({.component = component, .sessions = {second}}).points.empty());
  const absl::Status unknown =
      client_->QueryRegion({.sessions = {SessionId("nobody-7")}}, [](const auto&) { return true; });
  EXPECT_TRUE(absl::IsNotFound(unknown)) << unknown;
}

// The finest of the resolutions that fits, and what it gives.
TEST_F(MapReadingTest, ABudgetOfPointsChoosesTheResolution) {
  Fill();
  const size_t all = Everything().points.size();
  EXPECT_EQ(Query({.max_points = all}).resolution_m, 0);
  for (const size_t most : {all - 1, all / 3, size_t{9}, size_t{2}}) {
    const RegionChunk some = Query({.max_points = most});
    EXPECT_LE(some.points.size(), most);
    EXPECT_GT(some.resolution_m, 0);
    if (most < 9) continue;  // No resolution has so few: eight voxels meet at the origin.
    EXPECT_EQ(Query({.resolution_m = some.resolution_m}).points.size(), some.points.size());
    const RegionQuery by_draco{.max_points = most, .rounding_m = 0.01, .with_draco = true};
    EXPECT_EQ(Named(some.robots, Query(by_draco).points),
              Named(some.robots, Query({.max_points = most, .rounding_m = 0.01}).points));
    EXPECT_GT(Query({.resolution_m = some.resolution_m / 2}).points.size(), most);
  }
}

TEST_F(MapReadingTest, PointsComeAsTheyAreAskedFor) {
  Fill();
  const RegionChunk all = Everything();
  const RegionChunk rounded = Query({.wants_stamp = true, .rounding_m = 0.01});
  ASSERT_EQ(rounded.points.size(), all.points.size());
  for (size_t i = 0; i < all.points.size(); ++i) {
    EXPECT_NEAR(rounded.points[i].x, all.points[i].x, 0.00501);
    EXPECT_EQ(rounded.points[i].stamp, all.points[i].stamp);
    EXPECT_EQ(rounded.points[i].intensity, all.points[i].intensity);
  }
  // The same points in another order.
  const RegionQuery by_draco{.wants_stamp = true, .rounding_m = 0.01, .with_draco = true};
  EXPECT_EQ(Named(all.robots, Query(by_draco).points), Named(all.robots, rounded.points));
  EXPECT_EQ(Named(all.robots, Query({.with_draco = true}).points),
            Named(all.robots, Query({.rounding_m = 0.001}).points));
  const RegionQuery nowhere{.sphere = RegionQuery::Sphere{{900, 0, 0}, 1}, .with_draco = true};
  EXPECT_TRUE(Query(nowhere).points.empty());
  const absl::Status stopped =
      client_->QueryRegion(by_draco, [](const RegionChunk&) { return false; });
  EXPECT_TRUE(absl::IsCancelled(stopped)) << stopped;
  v1::QueryRegionRequest request;
  request.add_attributes(v1::QueryRegionRequest::LAST_SEEN);
  std::vector<v1::QueryRegionResponse> responses;
  ASSERT_GRPC_OK(ReadAll(stubs_->map->QueryRegion(NewContext().get(), request), &responses));
  EXPECT_EQ(responses.back().cloud().stride(), 16u);
  EXPECT_EQ(responses.back().cloud().fields(3).name(), "last_seen");
}

TEST_F(MapReadingTest, AQueryGoesOnWhereItWasCutOff) {
  Fill();
  const RegionQuery query{.resolution_m = 2, .max_points = 1000};
  const RegionChunk whole = Query(query);
  RegionQuery rest = query;
  rest.resume = whole.next;
  rest.resume->points = whole.points.size() - 7;
  const RegionChunk last = Query(rest);
  ASSERT_EQ(last.points.size(), 7u);
  EXPECT_EQ(last.points.front().x, whole.points[whole.points.size() - 7].x);
  // A position is of the very request, encoding included; the place of the cut does not depend on
  // it.
  RegionQuery packed = query;
  packed.with_draco = true;
  packed.resume = Query(packed).next;
  EXPECT_EQ(packed.resume->points, whole.points.size());
  EXPECT_TRUE(Query(packed).points.empty());
  packed.resume->points -= 7;
  RegionQuery rounded = query;
  rounded.rounding_m = 0.001;
  auto expected = Query(rounded).points;
  expected.erase(expected.begin(), expected.end() - 7);
  EXPECT_EQ(Named(last.robots, Query(packed).points), Named(last.robots, expected));
  // At another resolution it would leave out other points than came.
  RegionQuery finer = rest;
  finer.resume->resolution_m /= 2;
  const absl::Status forged = client_->QueryRegion(finer, [](const auto&) { return true; });
  EXPECT_TRUE(absl::IsFailedPrecondition(forged)) << forged;
  packed.resume = rest.resume;
  const absl::Status raw = client_->QueryRegion(packed, [](const auto&) { return true; });
  EXPECT_TRUE(absl::IsFailedPrecondition(raw)) << raw;
  RegionQuery other = rest;
  other.resolution_m = 1;
  const absl::Status mixed = client_->QueryRegion(other, [](const auto&) { return true; });
  EXPECT_TRUE(absl::IsFailedPrecondition(mixed)) << mixed;
  Add(Open("carol"), "carol", 0);
  pipeline_->WaitUntilIdle();
  const absl::Status changed = client_->QueryRegion(rest, [](const auto&) { return true; });
  EXPECT_TRUE(absl::IsFailedPrecondition(changed)) << changed;
}

// Robots come, drive and go, maps are joined and parted: at every revision that the mirror reaches
// it has what queries for everything give.
TEST_F(MapReadingTest, AMirrorHasTheMapOfEachRevisionItReaches) {
  Fill();
  std::thread drives([&] {
    const SessionId carol = Open("carol"), dave = Open("dave");
    for (uint32_t i = 0; i < 3; ++i) {
      Add(carol, "carol", i, 10);
      Add(dave, "dave", i, 10);
    }
  });
  int compared = 0, changes = 0;
  const auto is_same = [&](const MapMirror& mirror) {
    uint32_t component = 0;
    for (;; ++component) {
      RegionChunk all;
      const RegionQuery query{.component = component, .wants_stamp = true};
      const absl::Status read = client_->QueryRegion(query, [&](const RegionChunk& chunk) {
        all.revision = chunk.revision;
        all.robots = chunk.robots;
        all.points.insert(all.points.end(), chunk.points.begin(), chunk.points.end());
        return true;
      });
      if (absl::IsNotFound(read)) break;  // There are no more.
      EXPECT_TRUE(read.ok()) << read;
      if (all.revision != mirror.revision()) return false;  // The server is further by now.
      const RegionChunk mine = mirror.Points(component);
      EXPECT_EQ(Named(mine.robots, mine.points), Named(all.robots, all.points));
    }
    if (client_->ListTiles(0)->revision != mirror.revision()) return false;
    EXPECT_LT(mirror.tiles().rbegin()->first.component, component);
    ++compared;
    return true;
  };
  const auto join = [&](const char* robot, double x) {
    MatchDecision set;
    set.robot_a = RobotId("alice");
    set.robot_b = RobotId(robot);
    set.kind = ManualDecisionKind::kSet;
    set.T_a_b = Pose(Eigen::Vector3d(x, 5, 0));
    EXPECT_TRUE(pipeline_->decisions().DecideMatch(set).ok());
  };
  MapMirror mirror(client_.get());
  const absl::Status status = mirror.Follow([&](const MapMirror& at) {
    const bool is_compared = is_same(at);
    switch (++changes) {  // Each brings a step more.
      case 1:
        join("bob", 3);
        return true;
      case 2:
        drives.join();
        join("dave", 7);
        return true;
      case 3:
        join("dave", 27);
        return true;
      case 4:
        EXPECT_TRUE(pipeline_->sessions().Delete(SessionId("bob-1")).ok());
        return true;
      case 5:
        Add(SessionId("carol-1"), "carol", 3, 10);
        return true;
      default:
        return !is_compared;
    }
  });
  if (drives.joinable()) drives.join();
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_GT(compared, 1);
}

// Everything that a map can be asked for by name.
struct NamedMap {
  std::vector<NamedPoint> points, tile;
  std::string file, octomap, graph;
  size_t tiles = 0, submaps_after = 0;
};

void ExpectSame(const NamedMap& read, const NamedMap& expected) {
  EXPECT_EQ(read.points, expected.points);
  EXPECT_EQ(read.tile, expected.tile);
  EXPECT_EQ(read.file, expected.file);
  EXPECT_EQ(read.octomap, expected.octomap);
  EXPECT_EQ(read.graph, expected.graph);
  EXPECT_EQ(read.tiles, expected.tiles);
  EXPECT_EQ(read.submaps_after, expected.submaps_after);
}

class MapNameTest : public MapReadingTest {
 protected:
  std::string File(const MapName& map, ExportFormat format) {
    std::string file;
    const auto summary =
        client_->Export({.format = format, .component = map}, [&](const std::string& bytes) {
          file += bytes;
          return true;
        });
    EXPECT_TRUE(summary.ok()) << summary.status();
    return file;
  }
  NamedMap Read(const MapName& map) {
    NamedMap read;
    const RegionChunk all = Query({.component = map, .wants_stamp = true});
    read.points = Named(all.robots, all.points);
    read.file = File(map, ExportFormat::kPcdBinary);
    read.file.erase(0, read.file.find("VERSION"));  // All robots of the server are named above.
    read.octomap = File(map, ExportFormat::kOctoMapBinary);
    v1::ExportPoseGraphRequest graph;
    graph.set_component(map.number());
    graph.set_map(map.session().value());
    v1::ExportPoseGraphResponse merged;
    EXPECT_GRPC_OK(Merged(stubs_->map->ExportPoseGraph(NewContext().get(), graph), &merged));
    read.graph = merged.data();
    const auto tiles = client_->ListTiles(map);
    EXPECT_TRUE(tiles.ok()) << tiles.status();
    if (!tiles.ok() || tiles->tiles.empty()) return read;
    read.tiles = tiles->tiles.size();
    v1::GetTileRequest tile;
    tile.mutable_id()->set_x(tiles->tiles[0].id.x);
    tile.mutable_id()->set_y(tiles->tiles[0].id.y);
    tile.mutable_id()->set_component(map.number());
    tile.set_map(map.session().value());
    v1::GetTileResponse content;
    EXPECT_GRPC_OK(Merged(stubs_->map->GetTile(NewContext().get(), tile), &content));
    const auto points = codec::ReadTilePoints(content.points());
    EXPECT_TRUE(points.ok()) << points.status();
    read.tile = Named({content.robots().begin(), content.robots().end()}, *points);
    const auto changes =
        client_->FindChanges({.since_ns = (kFirstSecond + 1) * 1'000'000'000, .component = map});
    EXPECT_TRUE(changes.ok()) << changes.status();
    if (changes.ok()) read.submaps_after = changes->submaps_after;
    return read;
  }
  // So many robots, all joined: more than anybody else's.
  void AddForged(int count) {
    for (int i = 0; i < count; ++i) {
      const std::string robot = absl::StrCat("mallory", i);
      Add(Open(robot), robot, 0, 5);
      if (i == 0) continue;
      MatchDecision set;
      set.robot_a = RobotId("mallory0");
      set.robot_b = RobotId(robot);
      set.kind = ManualDecisionKind::kSet;
      ASSERT_TRUE(pipeline_->decisions().DecideMatch(set).ok());
    }
    pipeline_->WaitUntilIdle();
  }
};

TEST_F(MapNameTest, GoesOnMeaningTheMapWhateverComesBesideIt) {
  Fill();
  const MapName alice(SessionId("alice-1"));
  const NamedMap before = Read(alice);
  EXPECT_EQ(before.points.size(), 90u);
  EXPECT_EQ(before.submaps_after, 2u);
  EXPECT_GT(before.tiles, 4u);
  ExpectSame(Read(0), before);
  AddForged(8);
  EXPECT_NE(Everything(0).points.size(), before.points.size()) << "the number is another's";
  ExpectSame(Read(alice), before);
}

TEST_F(MapNameTest, AnySessionNamesAMapThatWasJoined) {
  Fill();
  MatchDecision set;
  set.robot_a = RobotId("alice");
  set.robot_b = RobotId("bob");
  set.kind = ManualDecisionKind::kSet;
  ASSERT_TRUE(pipeline_->decisions().DecideMatch(set).ok());
  pipeline_->WaitUntilIdle();
  const NamedMap both = Read(MapName(SessionId("alice-1")));
  EXPECT_EQ(both.points.size(), 110u);
  ExpectSame(Read(MapName(SessionId("bob-1"))), both);
}

TEST_F(MapNameTest, OfADeletedSessionIsNotFound) {
  Fill();
  ASSERT_TRUE(pipeline_->sessions().Delete(SessionId("bob-1")).ok());
  pipeline_->WaitUntilIdle();
  const MapName bob(SessionId("bob-1"));
  const auto none = [](const auto&) { return true; };
  for (const absl::Status& status :
       {client_->QueryRegion({.component = bob}, none), client_->ListTiles(bob).status(),
        client_->Export({.component = bob}, none).status(),
        client_->Export({.format = ExportFormat::kOctoMapFull, .component = bob}, none).status(),
        client_->FindChanges({.since_ns = 1, .component = bob}).status()}) {
    EXPECT_TRUE(absl::IsNotFound(status)) << status;
    EXPECT_THAT(std::string(status.message()), testing::HasSubstr("it was deleted"));
  }
}

// Unchanged tiles are not asked for again, also after a break; and nothing is missed in it.
TEST_F(MapReadingTest, AMirrorAsksForWhatChangedAlone) {
  Fill();
  MapMirror mirror(client_.get());
  const auto once = [](const MapMirror&) { return false; };
  ASSERT_TRUE(mirror.Follow(once).ok());
  const uint64_t fetched = mirror.tiles_fetched();
  EXPECT_EQ(fetched, mirror.tiles().size());
  const size_t places = mirror.submaps().size();
  EXPECT_EQ(places, 4u);
  const SessionId carol = Open("carol");
  Add(carol, "carol", 0, 1);
  pipeline_->WaitUntilIdle();
  const int64_t newest = client_->GetMapInfo()->revision;
  ASSERT_TRUE(mirror.Follow([&](const MapMirror& at) { return at.revision() < newest; }).ok());
  EXPECT_EQ(mirror.tiles_fetched(), fetched + 1);
  EXPECT_EQ(mirror.submaps().size(), places + 1);
}

TEST_F(MapReadingTest, AWatchTellsOfMatchesAndPlaces) {
  Fill();
  MatchDecision join;
  join.robot_a = RobotId("alice");
  join.robot_b = RobotId("bob");
  join.kind = ManualDecisionKind::kSet;
  bool has_begun = false, has_match = false;
  std::set<SubmapId> moved;
  const absl::Status status = client_->WatchMap({}, 0, [&](const MapStep& step) {
    if (!has_begun) {
      EXPECT_TRUE(step.restart);
      EXPECT_EQ(step.submaps.size(), 4u);
      has_begun = true;
      EXPECT_TRUE(pipeline_->decisions().DecideMatch(join).ok());
      return true;
    }
    for (const MatchEdge& edge : step.matches) {
      has_match = has_match || (edge.manual_decision && edge.match.b == SessionId("bob-1"));
    }
    for (const SubmapPlace& place : step.submaps) moved.insert(place.submap);
    return !(has_match && moved.contains({SessionId("bob-1"), 0}));
  });
  EXPECT_TRUE(status.ok()) << status;
}

}  // namespace
}  // namespace isthmus::rpc
