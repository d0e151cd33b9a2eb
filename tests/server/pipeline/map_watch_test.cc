// A reader that is told steps of the map has the whole map, however rarely it asks.
#include "server/pipeline/map_watch.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <random>
#include <thread>

#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

using Versions = std::map<TileId, uint64_t>;

// A table of tiles; level 1 is made of those of level 0, as far as versions go.
class TableMap : public ComposedMap {
 public:
  TableMap(int64_t revision, Versions tiles, std::vector<uint32_t> levels)
      : revision_(revision), tiles_(std::move(tiles)), levels_(std::move(levels)) {}

  int64_t revision() const override { return revision_; }
  const std::vector<RobotId>& robots() const override { return robots_; }
  uint32_t component_count() const override { return static_cast<uint32_t>(levels_.size()); }
  uint64_t point_count(uint32_t) const override { return 0; }
  Box bounds(uint32_t) const override { return {}; }
  absl::Status Read(const Region&, size_t, const Emit&) const override { return {}; }
  double tile_m() const override { return 20; }
  uint32_t tile_levels(uint32_t component) const override { return levels_[component]; }
  std::vector<TileInfo> Tiles(uint32_t component, uint32_t level) const override {
    std::map<TileId, uint64_t> at_level;
    for (const auto& [id, version] : tiles_) {
      if (id.component != component) continue;
      uint64_t& sum = at_level[{component, level, id.x >> level, id.y >> level}];
      sum = sum * 31 + version * 17 + static_cast<uint64_t>(id.x * 7 + id.y);
    }
    std::vector<TileInfo> infos;
    for (const auto& [id, version] : at_level) infos.push_back({id, version, revision_, 1, {}});
    return infos;
  }

 private:
  const int64_t revision_;
  const Versions tiles_;
  const std::vector<uint32_t> levels_;
  const std::vector<RobotId> robots_;
};

// A reader's knowledge of the map, made of steps.
struct Reader {
  MapMark mark;
  Versions tiles;
  std::map<SubmapId, std::pair<uint32_t, double>> submaps;
  std::map<std::pair<SessionId, SessionId>, int64_t> matches;
  int restarts = 0;

  void Take(const MapStep& step) {
    if (step.restart) {
      ++restarts;
      tiles.clear();
      submaps.clear();
      matches.clear();
    }
    for (const TileId& id : step.removed_tiles) tiles.erase(id);
    for (const TileInfo& tile : step.tiles) tiles[tile.id] = tile.version;
    for (const SubmapPlace& place : step.submaps) {
      submaps.erase(place.submap);
      if (!place.component) continue;
      submaps[place.submap] = {*place.component, place.T_map_submap.translation().x()};
    }
    for (const auto& pair : step.removed_matches) matches.erase(pair);
    for (const MatchEdge& edge : step.matches) {
      matches[{edge.match.a, edge.match.b}] = edge.match.computed_ns;
    }
    mark = step.mark;
  }
};

// A map that changes at random, and what a reader of it should know.
class RandomMaps {
 public:
  std::shared_ptr<const ComposedMap> map;
  MapView view;

  void Change() {
    ++revision_;
    const auto some = [this](uint32_t n) { return static_cast<uint32_t>(random_() % n); };
    for (int i = 0; i < 3; ++i) {
      const TileId id{some(2), 0, static_cast<int32_t>(some(8)) - 4,
                      static_cast<int32_t>(some(8)) - 4};
      if (some(3) == 0) {
        tiles_.erase(id);
      } else {
        tiles_[id] = random_();
      }
    }
    auto placed = std::make_shared<MapRevision>();
    placed->revision = revision_;
    for (const char* session : {"alice-1", "bob-1"}) {
      Placement& placement = placed->placements.emplace_back();
      placement.session = SessionId(session);
      placement.component = some(2);
      for (uint32_t i = 0; i < 5; ++i) {
        if (some(4) == 0) continue;
        placement.submaps.push_back({i, Pose(Eigen::Vector3d(some(3), 0, 0))});
      }
    }
    view.revision = placed;
    auto matches = std::make_shared<std::vector<Match>>();
    if (some(2) == 0) {
      matches->emplace_back();
      matches->back().a = SessionId("alice-1");
      matches->back().b = SessionId("bob-1");
      matches->back().computed_ns = some(3);
    }
    view.effective = matches;
    levels_ = {2, some(6) == 0 ? 1u : 2u};
    map = std::make_shared<TableMap>(revision_, tiles_, levels_);
  }

  Reader Truth(uint32_t level) const {
    Reader truth;
    for (uint32_t c = 0; c < 2; ++c) {
      const uint32_t told = std::min(level, levels_[c] - 1);
      for (const TileInfo& tile : map->Tiles(c, told)) truth.tiles[tile.id] = tile.version;
    }
    for (const Placement& placement : view.revision->placements) {
      for (const SubmapPose& pose : placement.submaps) {
        truth.submaps[{placement.session, pose.index}] = {placement.component,
                                                          pose.T_map_submap.translation().x()};
      }
    }
    for (const Match& match : *view.effective)
      truth.matches[{match.a, match.b}] = match.computed_ns;
    return truth;
  }

 private:
  std::mt19937_64 random_{7};
  int64_t revision_ = 0;
  Versions tiles_;
  std::vector<uint32_t> levels_;
};

void ExpectSame(const Reader& reader, const Reader& truth) {
  EXPECT_EQ(reader.tiles, truth.tiles);
  EXPECT_EQ(reader.submaps, truth.submaps);
  EXPECT_EQ(reader.matches, truth.matches);
}

// Readers that ask after every map, after some, and with a log that holds a few steps.
TEST(MapWatchTest, ReadersKnowTheMapHoweverRarelyTheyAsk) {
  for (const size_t max_logged : {size_t{1000}, size_t{40}, size_t{0}}) {
    for (const uint32_t level : {0u, 1u}) {
      MapWatch watch(max_logged);
      RandomMaps maps;
      maps.Change();
      watch.Note(maps.view, maps.map);
      std::vector<Reader> readers(3);
      for (int i = 1; i <= 200; ++i) {
        maps.Change();
        watch.Note(maps.view, maps.map);
        for (size_t r = 0; r < readers.size(); ++r) {
          if (i % (1 + 7 * static_cast<int>(r)) != 0) continue;
          readers[r].Take(*watch.Since(readers[r].mark, level));
          ExpectSame(readers[r], maps.Truth(level));
        }
      }
      if (level == 0) {
        EXPECT_EQ(readers[0].restarts > 1, max_logged == 0) << max_logged;
        EXPECT_EQ(readers[2].restarts > 1, max_logged <= 40) << max_logged;
      }
    }
  }
}

TEST(MapWatchTest, StepsHoldWhatIsNewAlone) {
  MapWatch watch;
  RandomMaps maps;
  for (int i = 0; i < 50; ++i) maps.Change();
  watch.Note(maps.view, maps.map);
  Reader reader;
  reader.Take(*watch.Since({}, 0));
  EXPECT_GT(reader.tiles.size(), 20u);
  maps.Change();
  watch.Note(maps.view, maps.map);
  const MapStep step = *watch.Since(reader.mark, 0);
  EXPECT_FALSE(step.restart);
  EXPECT_LE(step.tiles.size() + step.removed_tiles.size(), 3u);
  EXPECT_TRUE(watch.Since(step.mark, 0)->tiles.empty());
}

// Revisions of another server, or of one that was put back to an older state, say nothing.
TEST(MapWatchTest, ARevisionOfAnotherRunBeginsAnew) {
  RandomMaps maps;
  maps.Change();
  MapWatch first, second;
  first.Note(maps.view, maps.map);
  second.Note(maps.view, maps.map);
  const MapStep from_first = *first.Since({}, 0);
  EXPECT_TRUE(second.Since(from_first.mark, 0)->restart);
  MapMark later = from_first.mark;
  ++later.revision;
  EXPECT_TRUE(first.Since(later, 0)->restart);
  EXPECT_FALSE(first.Since(from_first.mark, 0)->restart);
}

// A revision has a second map if a large submap came after others.
TEST(MapWatchTest, ASecondMapOfARevisionBeginsAnew) {
  RandomMaps maps;
  for (int i = 0; i < 30; ++i) maps.Change();
  MapWatch watch;
  watch.Note(maps.view, maps.map);
  Reader reader;
  reader.Take(*watch.Since({}, 0));
  const auto second =
      std::make_shared<TableMap>(maps.map->revision(), Versions(), std::vector<uint32_t>{2, 2});
  watch.Note(maps.view, second);
  const MapStep step = *watch.Since(reader.mark, 0);
  EXPECT_TRUE(step.restart);
  EXPECT_TRUE(step.tiles.empty());
  EXPECT_NE(step.mark.run, reader.mark.run);
  EXPECT_FALSE(watch.Since(step.mark, 0)->restart);
}

TEST(MapWatchTest, NothingIsToldBeforeThereIsAMap) {
  MapWatch watch;
  int woken = 0;
  const uint64_t handle = watch.OnChange([&] { ++woken; });
  EXPECT_FALSE(watch.Since({}, 0));
  RandomMaps maps;
  maps.Change();
  watch.Note(maps.view, maps.map);
  EXPECT_EQ(woken, 1);
  EXPECT_TRUE(watch.Since({}, 0)->restart);
  watch.Forget(handle);
  maps.Change();
  watch.Note(maps.view, maps.map);
  EXPECT_EQ(woken, 1);
}

// Once nothing is under way all that watch the map were told of it.
TEST(MapWatchTest, AMapIsNotSettledBeforeWhoWatchesItWasTold) {
  const auto pipeline = OpenInMemory();
  ASSERT_TRUE(pipeline->feed().Since({}, 0).has_value());
  std::atomic<int> told = 0;
  std::atomic<bool> was_settled = false;
  const uint64_t handle = pipeline->feed().OnChange([&] {
    // All but this is done by then.
    while (!pipeline->GetLoad().matching.is_idle) std::this_thread::yield();
    if (pipeline->GetMapInfo().settled) was_settled = true;
    ++told;
  });
  Submap wall;
  wall.id = {Create(*pipeline, kAlice), 0};
  wall.keyframes = {{0, 1'000, Pose()}, {0, 2'000, Pose(Eigen::Vector3d(1, 0, 0))}};
  for (int i = 0; i < 400; ++i) {
    wall.points.push_back({3.f, 0.2f * static_cast<float>(i % 20),
                           0.2f * static_cast<float>(i / 20), 1.f, uint16_t(i % 2)});
  }
  ASSERT_TRUE(pipeline->sessions().AddSubmap(wall).ok());
  pipeline->WaitUntilIdle();
  EXPECT_GT(told, 0);
  EXPECT_FALSE(was_settled);
  EXPECT_TRUE(pipeline->GetMapInfo().settled);
  pipeline->feed().Forget(handle);
}

}  // namespace
}  // namespace isthmus::server
