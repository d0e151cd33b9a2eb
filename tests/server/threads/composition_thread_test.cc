// Readers' answers while the map is composed, and when it cannot be.
#include "server/threads/composition_thread.h"

#include <absl/strings/match.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <memory>
#include <new>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/threads/limits.h"
#include "tests/server/threads/placed_map.h"

namespace isthmus::server {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

class CompositionThreadTest : public PlacedMapTest {
 protected:
  void SetUp() override { ASSERT_NO_FATAL_FAILURE(Begin({.sessions = {SessionOf("alice")}})); }

  // Points in rows of 1000, 1 m apart.
  void Add(uint32_t index, int points) {
    auto submap = std::make_shared<Submap>();
    submap->id = {kSession, index};
    submap->robot = RobotId("alice");
    submap->first_sequence = submap->last_sequence = index + 1;
    submap->keyframes = {{index + 1, 1'000'000'000 * int64_t{index + 1}, Pose()}};
    for (int i = 0; i < points; ++i) {
      const int row = i / 1000;
      submap->points.push_back({float(i % 1000), 0.5f + float(row), 0.5f, 0, 0});
    }
    FinishedSubmap finished;
    finished.submap = submap;
    finished.trajectory = {{index + 1, 1'000'000'000 * int64_t{index + 1}, Pose(), index}};
    ASSERT_TRUE(map_.AddSubmap(kSession, finished).ok());
    map_.WaitUntilPlaced();
  }

  static std::string NewFolder(const std::string& name) {
    const std::string folder = testing::TempDir() + name;
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
  }

  std::shared_ptr<const ComposedMap> Map() { return map_.view()->map; }
  std::shared_ptr<const ComposedMap> ComposedMapOnceThere() {
    while (true) {
      const uint64_t seen = map_.changed().count();
      const MapWriter::View view = map_.view();
      if (view->IsComposed()) return view->map;
      map_.changed().WaitPast(seen);
    }
  }

  // The first map of which that is true.
  std::shared_ptr<const ComposedMap> MapOnce(const std::function<bool(const ComposedMap&)>& is_so) {
    while (true) {
      const uint64_t seen = map_.changed().count();
      if (auto map = Map(); is_so(*map)) return map;
      map_.changed().WaitPast(seen);
    }
  }

  // Composes the map and keeps it in the folder, as an earlier process would have: nobody holds it
  // afterwards.
  void KeepMap(const composition::ComposerOptions& options) {
    {
      CompositionThread composition(&map_, &activity_, reader_, options, 0);
      ComposedMapOnceThere();
    }
    map_.ShowComposed(std::make_shared<LoadingMap>(std::vector<RobotId>(), 0));
  }

  const SubmapReader reader_ = [this](const SubmapId& id) { return submaps_.Get(id); };
};

TEST_F(CompositionThreadTest, EmptyMapIsReadyAtOnce) {
  CompositionThread composition(&map_, &activity_, reader_, {}, 0);
  EXPECT_TRUE(Map()->ready().ok());
  EXPECT_EQ(Map()->component_count(), 0u);
}

TEST_F(CompositionThreadTest, StoredMapIsUnavailableRatherThanEmptyUntilItIsComposed) {
  Add(0, 3);
  std::promise<void> go;
  const auto slow = [this, gone = go.get_future().share()](const SubmapId& id) {
    gone.wait();
    return submaps_.Get(id);
  };
  CompositionThread composition(&map_, &activity_, slow, {}, 0);
  const auto starting = Map();
  EXPECT_EQ(starting->ready().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(starting->ready().message()), HasSubstr("0 %"));
  EXPECT_EQ(starting->Read({}, 10, [](const auto&) { return true; }).code(),
            absl::StatusCode::kUnavailable);
  EXPECT_EQ(starting->component_count(), 1u) << "or readers would hear that there is none";
  EXPECT_EQ(starting->robots(), std::vector<RobotId>{RobotId("alice")});
  go.set_value();
  const auto map = ComposedMapOnceThere();
  EXPECT_TRUE(map->ready().ok());
  EXPECT_EQ(map->point_count(0), 3u);
}

TEST_F(CompositionThreadTest, StopsInTheMiddleOfTheFirstMap) {
  for (uint32_t i = 0; i < 5; ++i) Add(i, 3);
  std::atomic<int> reads = 0;
  std::unique_ptr<CompositionThread> composition;
  std::promise<void> begun, stopped;
  composition = std::make_unique<CompositionThread>(
      &map_, &activity_,
      [&, gone = stopped.get_future().share()](const SubmapId& id) {
        if (reads++ == 0) begun.set_value();
        gone.wait();
        return submaps_.Get(id);
      },
      composition::ComposerOptions(), 0);
  begun.get_future().wait();
  composition->Stop();
  stopped.set_value();
  composition = nullptr;
  EXPECT_EQ(reads, 1);
}

TEST_F(CompositionThreadTest, StopsInTheMiddleOfASubmap) {
  Add(0, 300'000);
  std::promise<CompositionThread*> made;
  auto composition = std::make_unique<CompositionThread>(
      &map_, &activity_,
      [&, gone = made.get_future().share()](const SubmapId& id) {
        gone.get()->Stop();
        return submaps_.Get(id);
      },
      composition::ComposerOptions(), 0);
  const auto starting = Map();
  made.set_value(composition.get());
  composition = nullptr;
  EXPECT_THAT(std::string(starting->ready().message()), HasSubstr(", 0 %"));
}

// It would show what is no more, and the memory would be gone for longer.
TEST_F(CompositionThreadTest, DeletingASessionEndsTheCompositionUnderWay) {
  Add(0, 300'000);
  std::promise<void> go;
  CompositionThread composition(
      &map_, &activity_,
      [&, gone = go.get_future().share()](const SubmapId& id) {
        gone.wait();
        auto submap = submaps_.Get(id);
        EXPECT_TRUE(map_.RemoveSession(kSession).ok());  // Waits for no composition.
        return submap;
      },
      {}, 0);
  const auto starting = Map();
  go.set_value();
  EXPECT_EQ(ComposedMapOnceThere()->point_count(0), 0u);
  EXPECT_THAT(std::string(starting->ready().message()), HasSubstr(", 0 %"));
}

// A large submap is at hand when a robot's next one comes: the small one is in the map first.
TEST_F(CompositionThreadTest, OthersComeBeforeALargeSubmap) {
  constexpr int kLarge = static_cast<int>(kTurnPoints) + 1;
  std::atomic<int> reads = 0;  // Reads of the large submap.
  const auto reader = [&](const SubmapId& id) {
    if (id.index == 1 && reads++ == 0) Add(2, 5);
    return submaps_.Get(id);
  };
  std::vector<std::pair<uint64_t, uint64_t>> shown;  // Points, and submaps that wait.
  const auto note = [&](const MapView&, const std::shared_ptr<const ComposedMap>& map) {
    shown.emplace_back(map->point_count(0), map->waiting_submaps());
  };
  auto composition = std::make_unique<CompositionThread>(
      &map_, &activity_, reader, composition::ComposerOptions(), 0, nullptr, note);
  Add(0, 3);
  EXPECT_EQ(ComposedMapOnceThere()->point_count(0), 3u);
  Add(1, kLarge);
  EXPECT_EQ(ComposedMapOnceThere()->waiting_submaps(), 0u);
  composition = nullptr;
  // They lie on each other.
  EXPECT_THAT(shown, ElementsAre(Pair(0, 0), Pair(3, 0), Pair(5, 1), Pair(kLarge, 0)));
  EXPECT_EQ(reads, 2) << "it was at hand when it gave way";
}

TEST_F(CompositionThreadTest, SaysOnceWhatTheMapHasNoRoomFor) {
  std::atomic<int> times = 0;
  std::promise<std::string> told;
  composition::ComposerOptions options;
  options.max_tiles = 8;  // A submap may lie on one of them.
  CompositionThread composition(&map_, &activity_, reader_, options, 0,
                                [&](const std::string& problem) {
                                  if (times++ == 0) told.set_value(problem);
                                });
  Add(0, 50);
  const std::string problem = told.get_future().get();
  EXPECT_THAT(problem, HasSubstr("leaves out 50 points, most of them of submap alice-1/0"));
  EXPECT_THAT(problem, HasSubstr("composition.tile_m"));
  Add(1, 5);
  EXPECT_EQ(ComposedMapOnceThere()->point_count(0), 5u);
  EXPECT_EQ(times, 1);
}

TEST_F(CompositionThreadTest, FullDiskKeepsTheLastMapAndIsToldOnce) {
  Add(0, 3);
  composition::ComposerOptions options;
  options.cache_bytes = 1000;
  options.folder = NewFolder("full_disk");
  options.reserve_bytes = uint64_t{1} << 62;  // No disk has so much to spare.
  std::promise<std::string> told;
  std::atomic<int> times = 0, times_not_kept = 0;
  CompositionThread composition(&map_, &activity_, reader_, options, 0,
                                [&](const std::string& problem) {
                                  if (absl::StrContains(problem, "not kept for the next start")) {
                                    ++times_not_kept;
                                  } else if (times++ == 0) {
                                    told.set_value(problem);
                                  }
                                });
  const auto map = ComposedMapOnceThere();
  Add(1, 5000);
  const std::string problem = told.get_future().get();
  EXPECT_THAT(problem, HasSubstr("the merged map stays as it was"));
  EXPECT_THAT(problem, HasSubstr("No space left"));
  EXPECT_EQ(Map(), map);
  EXPECT_FALSE(map_.view()->IsComposed());
  EXPECT_EQ(times, 1);
  EXPECT_EQ(times_not_kept, 1);
}

TEST_F(CompositionThreadTest, TheMapOfBeforeIsThereAtOnceAndOnlyNewSubmapsAreRead) {
  composition::ComposerOptions options;
  options.folder = NewFolder("kept_map");
  Add(0, 3);
  KeepMap(options);
  Add(1, 5);
  Add(2, static_cast<int>(kTurnPoints) + 1);
  std::promise<void> go;
  std::set<uint32_t> read;
  CompositionThread composition(
      &map_, &activity_,
      [&, gone = go.get_future().share()](const SubmapId& id) {
        if (id.index == 2) gone.wait();
        read.insert(id.index);
        return submaps_.Get(id);
      },
      options, 0);
  const auto first = MapOnce([](const ComposedMap& map) { return map.ready().ok(); });
  EXPECT_EQ(first->point_count(0), 5u);  // Without the large one, which has to be read.
  EXPECT_EQ(first->waiting_submaps(), 1u);
  go.set_value();
  MapOnce([](const ComposedMap& map) { return map.waiting_submaps() == 0; });
  EXPECT_THAT(read, ElementsAre(1, 2));
}

TEST_F(CompositionThreadTest, TilesThatAreDamagedOnTheDiskComeBackWithoutARestart) {
  composition::ComposerOptions options;
  options.folder = NewFolder("damaged_map");
  Add(0, 3000);
  KeepMap(options);
  const std::string path = options.folder + "/composed.points";
  CompositionThread composition(&map_, &activity_, reader_, options, 0);
  MapOnce([](const ComposedMap& map) { return map.ready().ok(); });
  std::ofstream(path, std::ios::in | std::ios::out)
      << std::string(std::filesystem::file_size(path), '\0');
  const auto read = [](const ComposedMap& map) {
    return map.Read({}, 1000, [](const auto&) { return true; });
  };
  const absl::Status status = read(*Map());
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  MapOnce([&](const ComposedMap& map) { return read(map).ok(); });
}

TEST_F(CompositionThreadTest, AMapThatCannotBeKeptIsToldAtTheStart) {
  composition::ComposerOptions options;
  options.folder = NewFolder("pipe_in_the_way");
  ASSERT_EQ(mkfifo((options.folder + "/composed.points").c_str(), 0600), 0);
  std::promise<std::string> told;
  CompositionThread composition(&map_, &activity_, reader_, options, 0,
                                [&](const std::string& problem) { told.set_value(problem); });
  EXPECT_THAT(told.get_future().get(),
              AllOf(HasSubstr("the merged map is not kept for the next start: "),
                    HasSubstr("remove it while no server runs")));
  Add(0, 3);
  EXPECT_EQ(ComposedMapOnceThere()->point_count(0), 3u);
}

// Not "40 % so far: try again" for ever.
TEST_F(CompositionThreadTest, AMapThatCannotBeComposedAfterAStartSaysWhy) {
  Add(0, 5000);
  composition::ComposerOptions options;
  options.cache_bytes = 1000;
  options.folder = NewFolder("full_disk_at_start");
  options.reserve_bytes = uint64_t{1} << 62;  // No disk has so much to spare.
  std::promise<void> told;
  std::atomic<int> times = 0;
  CompositionThread composition(&map_, &activity_, reader_, options, 0,
                                [&](const std::string& /*problem*/) {
                                  if (times++ == 0) told.set_value();
                                });
  const auto starting = Map();
  told.get_future().wait();
  EXPECT_EQ(starting->ready().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(starting->ready().message()),
              AllOf(HasSubstr("No space left"), HasSubstr("cache_mb")));
}

TEST_F(CompositionThreadTest, ASubmapAtWhichSomethingIsThrownIsNamedAndLeftOut) {
  Add(0, 10);
  Add(1, 5);
  std::atomic<int> times = 0;
  CompositionThread composition(
      &map_, &activity_,
      [this](const SubmapId& id) {
        if (id.index == 0) throw std::runtime_error("an odd submap");
        return submaps_.Get(id);
      },
      {}, 0, [&](const std::string&) { ++times; });
  EXPECT_EQ(ComposedMapOnceThere()->point_count(0), 5u);
  EXPECT_THAT(activity_.damage(),
              ElementsAre(AllOf(HasSubstr("submap alice-1/0 is left out of the merged map: "),
                                HasSubstr("an odd submap"))));
  Add(2, 7);
  EXPECT_EQ(ComposedMapOnceThere()->point_count(0), 7u);
  EXPECT_EQ(times, 1);
}

TEST_F(CompositionThreadTest, WhatIsThrownOnceLeavesNothingOut) {
  Add(0, 10);
  Add(1, 5);
  std::atomic<int> reads = 0;
  CompositionThread composition(
      &map_, &activity_,
      [&](const SubmapId& id) {
        if (reads++ == 1) throw std::runtime_error("for a moment");
        return submaps_.Get(id);
      },
      {}, 0);
  EXPECT_EQ(ComposedMapOnceThere()->point_count(0), 10u);
  EXPECT_TRUE(activity_.damage().empty());
}

}  // namespace
}  // namespace isthmus::server
