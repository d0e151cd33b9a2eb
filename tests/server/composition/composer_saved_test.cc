// Maps that outlive the process which composed them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "server/composition/composer.h"
#include "tests/server/composition/gallery.h"
#include "tests/server/composition/test_maps.h"
#include "tests/server/composition/tiles/failing_map_file.h"

namespace isthmus::composition {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// True: points leave that were looked through.
class SavedMap : public ::testing::TestWithParam<bool> {
 protected:
  SavedMap() {
    std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::replace(name.begin(), name.end(), '/', '_');
    folder_ = ::testing::TempDir() + "kept_" + name;
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    const auto walker = [](int k) {
      std::vector<Thing> things;
      if (k % 4 == 1) things.push_back(MakeBox({3.0, 0.8, 0}, {3.4, 1.2, 1.75}));
      return things;
    };
    const auto nobody = [](int) { return std::vector<Thing>(); };
    drives_ = {Drive("alice", 0, 0, walker), Drive("alice", 1, -1, nobody),
               Drive("bob", 0, -2, walker), Drive("bob", 1, 3, nobody),
               Drive("carol", 0, -1.5, nobody)};
  }
  ~SavedMap() override { std::filesystem::remove_all(folder_); }

  ComposerOptions Options(size_t cache_bytes = size_t{64} << 20) const {
    return {.cache_bytes = cache_bytes, .drop_gone = GetParam(), .folder = folder_};
  }
  // The map that is made of the same submaps without anything saved.
  std::shared_ptr<const ComposedMap> Anew(const std::vector<LaidSubmap>& submaps) const {
    Composer composer({.drop_gone = GetParam()});
    return isthmus::composition::Compose(&composer, 1, submaps);
  }
  void ExpectSame(const ComposedMap& map, const ComposedMap& expected) const {
    ASSERT_EQ(map.robots(), expected.robots());
    for (uint32_t component = 0; component < expected.component_count(); ++component) {
      Region region;
      region.component = component;
      ASSERT_EQ(Sorted(ReadAll(map, region)), Sorted(ReadAll(expected, region)));
      ASSERT_EQ(map.Tiles(component, 0).size(), expected.Tiles(component, 0).size());
    }
    if (GetParam()) {
      ASSERT_EQ(Sorted(ReadAll(*map.dropped())), Sorted(ReadAll(*expected.dropped())));
    }
  }

  void DamagePoints() const {
    std::fstream file(folder_ + "/composed.points", std::ios::in | std::ios::out);
    const std::string zeros(std::filesystem::file_size(folder_ + "/composed.points"), '\0');
    file.write(zeros.data(), static_cast<std::streamsize>(zeros.size()));
  }

  std::string folder_;
  std::vector<LaidSubmap> drives_;
};

INSTANTIATE_TEST_SUITE_P(DropGone, SavedMap, ::testing::Bool());

TEST_P(SavedMap, IsThereWithoutReadingASubmap) {
  {
    Composer composer(Options());
    EXPECT_THAT(composer.Known(Placed(drives_)), IsEmpty());
    Compose(&composer, 3, drives_);
    ASSERT_TRUE(composer.Save().ok());
  }
  Composer composer(Options());
  EXPECT_EQ(composer.Known(Placed(drives_)).size(), drives_.size());
  int reads = 0;
  const auto map = composer.Compose(4, Placed(drives_), ReaderOf(drives_, &reads));
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(reads, 0);
  EXPECT_EQ(composer.last_tiles_remade(), 0);
  ExpectSame(**map, *Anew(drives_));
  for (const TileInfo& tile : (*map)->Tiles(0, 0)) EXPECT_EQ(tile.revision, 3);
}

TEST_P(SavedMap, AfterAnyHistoryItIsThatMadeFromNothing) {
  std::mt19937 rng(5);
  std::vector<LaidSubmap> in_map;
  for (int revision = 1; revision <= 8; ++revision) {
    Stir(drives_, {.reach_m = 2, .erase_one_in = 4, .other_component_one_in = 6}, &rng, &in_map);
    Composer composer(Options(revision % 3 == 0 ? 1 : size_t{64} << 20));
    ExpectSame(*Compose(&composer, revision, in_map), *Anew(in_map));
    if (rng() % 4 > 0) {
      ASSERT_TRUE(composer.Save().ok());
    }
    Stir(drives_, {.reach_m = 2, .erase_one_in = 4, .other_component_one_in = 6}, &rng, &in_map);
    ExpectSame(*Compose(&composer, revision, in_map), *Anew(in_map));
    if (rng() % 4 == 0) {
      ASSERT_TRUE(composer.Save().ok());
    }
  }
}

TEST_P(SavedMap, OtherOptionsBeginAnew) {
  {
    Composer composer(Options());
    Compose(&composer, 1, drives_);
    ASSERT_TRUE(composer.Save().ok());
  }
  ComposerOptions options = Options();
  options.voxel_m = 0.2;
  Composer composer(options);
  EXPECT_THAT(composer.Known(Placed(drives_)), IsEmpty());
  Composer expected({.voxel_m = 0.2, .drop_gone = GetParam()});
  ExpectSame(*Compose(&composer, 1, drives_), *Compose(&expected, 1, drives_));
}

// The one that is saved is whole, though the next one was given up halfway.
TEST_P(SavedMap, AMapThatWasNotFinishedIsNotSaved) {
  const std::vector<LaidSubmap> first(drives_.begin(), drives_.begin() + 1);
  {
    Composer composer(Options());
    Compose(&composer, 1, first);
    ASSERT_TRUE(composer.Save().ok());
    const auto stopped = composer.Compose(2, Placed(drives_), ReaderOf(drives_),
                                          [](double share) { return share < 0.3; });
    ASSERT_TRUE(absl::IsCancelled(stopped.status()));
    ASSERT_TRUE(composer.Save().ok());
  }
  Composer composer(Options());
  EXPECT_THAT(composer.Known(Placed(drives_)), ElementsAre(first[0].submap->id));
  ExpectSame(*Compose(&composer, 3, drives_), *Anew(drives_));
}

// The same drives in another database, as of other settings: ids, stamps and sizes are alike.
TEST_P(SavedMap, OfAnotherDatabaseNothingIsTaken) {
  {
    Composer composer(Options());
    Compose(&composer, 1, drives_);
    ASSERT_TRUE(composer.Save().ok());
  }
  const std::vector<LaidSubmap> before = drives_;
  for (size_t i = 0; i + 1 < drives_.size(); ++i) {
    auto other = std::make_shared<Submap>(*drives_[i].submap);
    for (SubmapPoint& point : other->points) point.x += 0.3F;
    drives_[i].submap = std::move(other);
  }
  Composer composer(Options());
  EXPECT_THAT(composer.Known(Placed(drives_)), ElementsAre(before.back().submap->id));
  ExpectSame(*Compose(&composer, 2, drives_), *Anew(drives_));
  ExpectSame(*Compose(&composer, 3, before), *Anew(before));
}

// Rows of an older version do not tell their content: it is found when they are read, once.
TEST_P(SavedMap, SubmapsOfUnknownContentAreReadOnce) {
  std::vector<PlacedSubmap> placed = Placed(drives_);
  std::map<SubmapId, uint64_t> contents;
  for (PlacedSubmap& one : placed) {
    auto unknown = std::make_shared<SubmapInfo>(*one.submap);
    unknown->content = 0;
    one.submap = std::move(unknown);
  }
  int reads = 0;
  const auto compose = [&](Composer* composer) {
    const auto map = composer->Compose(1, placed, ReaderOf(drives_, &reads));
    ASSERT_TRUE(map.ok()) << map.status();
    ExpectSame(**map, *Anew(drives_));
    for (const auto& [id, content] : composer->TakeContents()) contents[id] = content;
  };
  for (int start = 0; start < 2; ++start) {  // At the second nobody has kept them.
    reads = 0;
    contents.clear();
    Composer composer(Options());
    compose(&composer);
    EXPECT_GE(reads, 5);
    EXPECT_EQ(contents.size(), drives_.size());
    reads = 0;
    compose(&composer);
    EXPECT_EQ(reads, 0);
    ASSERT_TRUE(composer.Save().ok());
  }
  for (PlacedSubmap& one : placed) {
    auto known = std::make_shared<SubmapInfo>(*one.submap);
    known->content = contents.at(one.submap->id);
    one.submap = std::move(known);
  }
  Composer composer(Options());
  compose(&composer);
  EXPECT_EQ(reads, 0);
}

// A disk that changes points must not change the map.
TEST_P(SavedMap, DamagedPointsAreReadFromTheStoreAgain) {
  {
    Composer composer(Options());
    Compose(&composer, 1, drives_);
    ASSERT_TRUE(composer.Save().ok());
  }
  DamagePoints();
  Composer composer(Options());
  for (LaidSubmap& laid : drives_) {
    laid.T_map_submap = Pose(Eigen::Vector3d(0, 1, 0)) * laid.T_map_submap;
  }
  ExpectSame(*Compose(&composer, 2, drives_), *Anew(drives_));
}

TEST_P(SavedMap, TilesThatAreDamagedAreComposedAgain) {
  {
    Composer composer(Options());
    Compose(&composer, 1, drives_);
    ASSERT_TRUE(composer.Save().ok());
  }
  Composer composer(Options());
  int told = 0;
  composer.TellLost([&] { ++told; });
  const auto map = Compose(&composer, 2, drives_);
  DamagePoints();
  const auto read = [&] { return map->Read({}, 1000, [](const auto&) { return true; }); };
  const absl::Status status = read();
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("composed again"));
  EXPECT_EQ(told, 1);
  EXPECT_TRUE(composer.has_lost());
  // One tile after the other, as readers meet them.
  auto mended = Compose(&composer, 2, drives_);
  EXPECT_GT(composer.last_tiles_remade(), 0);
  const auto is_whole = [&] {
    const auto take = [](const auto&) { return true; };
    const bool has_points = mended->Read({}, 1000, take).ok();
    return has_points && (!GetParam() || mended->dropped()->Read({}, 1000, take).ok());
  };
  while (!is_whole()) mended = Compose(&composer, 2, drives_);
  EXPECT_FALSE(composer.has_lost());
  ExpectSame(*mended, *Anew(drives_));
  ASSERT_TRUE(composer.Save().ok());
  EXPECT_TRUE(absl::IsUnavailable(read()));  // The map of before, for who holds it.
}

}  // namespace
}  // namespace isthmus::composition
