// Maps that are larger than the memory they may take.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "server/composition/composer.h"
#include "server/composition/voxel_thinner.h"
#include "tests/server/composition/test_maps.h"
#include "tests/server/composition/tiles/failing_map_file.h"

namespace isthmus::composition {
namespace {

// Submaps along a street that three robots drove through.
std::vector<LaidSubmap> Street(unsigned seed, int count = 12) {
  std::mt19937 rng(seed);
  std::vector<LaidSubmap> submaps;
  for (int i = 0; i < count; ++i) {
    const int row = i / 3;
    const Pose T_map_submap = Pose::FromXyzRpy(8 * row, rng() % 3, 0.1, 0.01, 0, 0.1 * i);
    const char* robots[] = {"carol", "alice", "bob"};
    submaps.push_back(MakeSubmap(robots[i % 3], static_cast<uint32_t>(i / 3),
                                 RandomPoints(&rng, 2000, MakeBox({-20, -20, -1}, {20, 20, 4})),
                                 T_map_submap));
  }
  return submaps;
}

constexpr size_t kStreetBytes = 12 * 2000 * sizeof(WeightedPoint);

ComposerOptions WithMemory(size_t bytes) {
  return {.tile_m = 10, .voxel_m = 0.2, .min_move_m = 0, .cache_bytes = bytes};
}

// Point for point, in the same order.
void ExpectSame(const ComposedMap& map, const ComposedMap& expected) {
  ASSERT_EQ(map.robots(), expected.robots());
  ASSERT_EQ(map.component_count(), expected.component_count());
  for (uint32_t component = 0; component < expected.component_count(); ++component) {
    Region region;
    region.component = component;
    const auto points = ReadAll(map, region), expected_points = ReadAll(expected, region);
    ASSERT_EQ(points.size(), expected_points.size());
    ASSERT_EQ(map.point_count(component), points.size());
    for (size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(points[i].x, expected_points[i].x) << i;
      ASSERT_EQ(points[i].y, expected_points[i].y) << i;
      ASSERT_EQ(points[i].z, expected_points[i].z) << i;
      ASSERT_EQ(points[i].intensity, expected_points[i].intensity) << i;
      ASSERT_EQ(points[i].robot, expected_points[i].robot) << i;
      ASSERT_EQ(points[i].stamp, expected_points[i].stamp) << i;
    }
  }
  ExpectSameTiles(map, expected);
}

// The amount of memory changes nothing but the time.
class AnyMemory : public ::testing::TestWithParam<size_t> {};

INSTANTIATE_TEST_SUITE_P(Bytes, AnyMemory,
                         ::testing::Values(0, 1, kStreetBytes / 8, kStreetBytes, kStreetBytes * 9));

TEST_P(AnyMemory, GivesTheSameMap) {
  const auto submaps = Street(1);
  auto file = std::make_shared<FailingMapFile>();
  Composer composer(WithMemory(GetParam()), file);
  Composer roomy(WithMemory(0));  // Without a file all stays in memory.
  ExpectSame(*Compose(&composer, 1, submaps), *Compose(&roomy, 1, submaps));
  EXPECT_EQ(roomy.memory().spilled_bytes, 0u);
  EXPECT_EQ(composer.memory().spilled_bytes > 0, GetParam() < kStreetBytes * 9);
  EXPECT_LE(composer.memory().submap_bytes + composer.memory().tile_bytes, GetParam());
}

TEST_P(AnyMemory, GivesTheSameMapAfterAnyHistory) {
  std::mt19937 rng(2);
  auto submaps = Street(2);
  auto file = std::make_shared<FailingMapFile>();
  Composer composer(WithMemory(GetParam()), file);
  std::vector<LaidSubmap> in_map;
  std::shared_ptr<const ComposedMap> before;
  for (int step = 0; step < 20; ++step) {
    Stir(submaps, {9, 4, 5}, &rng, &in_map);
    const auto points_before = before ? ReadAll(*before) : std::vector<MapPoint>();
    const auto map = Compose(&composer, step, in_map);
    Composer fresh(WithMemory(0));
    ExpectSame(*map, *Compose(&fresh, step, in_map));
    if (before) {
      EXPECT_EQ(Sorted(ReadAll(*before)), Sorted(points_before));
    }
    before = map;
  }
}

TEST_P(AnyMemory, EachSubmapIsReadOnce) {
  auto submaps = Street(3);
  Composer composer(WithMemory(GetParam()), std::make_shared<FailingMapFile>());
  int reads = 0;
  for (int revision = 0; revision < 3; ++revision) {
    submaps[revision].T_map_submap = Pose(Eigen::Vector3d(revision, 1, 0));
    const auto map = composer.Compose(revision, Placed(submaps), ReaderOf(submaps, &reads));
    ASSERT_TRUE(map.ok()) << map.status();
  }
  EXPECT_EQ(reads, static_cast<int>(submaps.size()));
}

// ThreadSanitizer watches what readers and composer share.
TEST_P(AnyMemory, ManyReadOldMapsWhileNewOnesAreMade) {
  auto submaps = Street(4);
  Composer composer(WithMemory(GetParam()), std::make_shared<FailingMapFile>());
  auto map = Compose(&composer, 0, submaps);
  std::vector<std::thread> readers;
  for (int revision = 1; revision <= 6; ++revision) {
    readers.emplace_back([kept = map] {
      const auto expected = Sorted(ReadAll(*kept));
      for (int i = 0; i < 4; ++i) EXPECT_EQ(Sorted(ReadAll(*kept)), expected);
    });
    submaps[revision].T_map_submap = Pose(Eigen::Vector3d(revision, 0, 0));
    map = Compose(&composer, revision, submaps);
  }
  for (std::thread& reader : readers) reader.join();
}

TEST(LargeMap, SpaceOfWhatIsGoneIsFree) {
  auto submaps = Street(5);
  auto file = std::make_shared<FailingMapFile>();
  std::shared_ptr<const ComposedMap> kept;
  {
    Composer composer(WithMemory(0), file);
    kept = Compose(&composer, 0, submaps);
    const uint64_t one_map = file->bytes_in_use();
    for (int revision = 1; revision < 20; ++revision) {
      for (LaidSubmap& laid : submaps)
        laid.T_map_submap = Pose(Eigen::Vector3d(0, 1, 0)) * laid.T_map_submap;
      Compose(&composer, revision, submaps);
    }
    EXPECT_LT(file->bytes_in_use(), 3 * one_map);
  }
  EXPECT_GT(file->bytes_in_use(), 0u);
  EXPECT_EQ(ReadAll(*kept).size(), kept->point_count(0));  // It outlives the composer.
  kept = nullptr;
  EXPECT_EQ(file->bytes_in_use(), 0u);
}

TEST(LargeMap, FullDiskLeavesTheOldMapAndIsOverOnceThereIsRoom) {
  auto submaps = Street(6);
  auto file = std::make_shared<FailingMapFile>();
  Composer composer(WithMemory(kStreetBytes / 8), file);
  const std::vector<LaidSubmap> few(submaps.begin(), submaps.begin() + 6);
  const auto old_map = Compose(&composer, 1, few);
  const auto old_points = Sorted(ReadAll(*old_map));
  // The file may fill at any write, and any number of times.
  for (int writes = 0; writes < 40; ++writes) {
    file->writes_left = writes % 5;
    submaps[writes % 12].T_map_submap = Pose(Eigen::Vector3d(writes, 2, 0));
    const auto failed = composer.Compose(2, Placed(submaps), ReaderOf(submaps));
    if (!failed.ok()) {
      EXPECT_EQ(failed.status().code(), absl::StatusCode::kResourceExhausted) << failed.status();
    }
    EXPECT_LE(composer.memory().submap_bytes + composer.memory().tile_bytes, kStreetBytes / 2);
  }
  EXPECT_EQ(Sorted(ReadAll(*old_map)), old_points);
  file->writes_left = 1 << 30;
  const auto map = Compose(&composer, 3, submaps);
  Composer roomy(WithMemory(0));
  ExpectSame(*map, *Compose(&roomy, 3, submaps));
}

TEST(LargeMap, TilesThatCannotBeReadFailTheReading) {
  auto file = std::make_shared<FailingMapFile>();
  Composer composer(WithMemory(0), file);
  const auto map = Compose(&composer, 1, Street(7));
  file->fail_reads = true;
  const absl::Status status =
      map->Read({}, 1000, [](const std::vector<MapPoint>&) { return true; });
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable) << status;
  EXPECT_TRUE(composer.has_lost());
  Region nowhere;
  nowhere.box = MakeBox({900, 900, 0}, {901, 901, 1});
  EXPECT_TRUE(map->Read(nowhere, 1000, [](const auto&) { return true; }).ok());
  file->fail_reads = false;
  EXPECT_EQ(ReadAll(*map).size(), map->point_count(0));
}

TEST(LargeMap, SubmapsLostFromTheFileAreReadFromTheStoreAgain) {
  auto submaps = Street(8);
  auto file = std::make_shared<FailingMapFile>();
  Composer composer(WithMemory(0), file);
  Compose(&composer, 1, submaps);
  int reads = 0;
  file->fail_reads = true;
  for (int attempt = 0; attempt < 5; ++attempt) {
    submaps[attempt].T_map_submap = Pose(Eigen::Vector3d(3, attempt, 0));
    const auto lost = composer.Compose(2, Placed(submaps), ReaderOf(submaps, &reads));
    ASSERT_FALSE(lost.ok());
    EXPECT_EQ(lost.status().code(), absl::StatusCode::kDataLoss) << lost.status();
  }
  file->fail_reads = false;
  const auto map = composer.Compose(3, Placed(submaps), ReaderOf(submaps, &reads));
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_GT(reads, 0);
  Composer roomy(WithMemory(0));
  ExpectSame(**map, *Compose(&roomy, 3, submaps));
}

TEST(LargeMap, CancelledCompositionGoesOnWhereItEnded) {
  const auto submaps = Street(9);
  Composer composer(WithMemory(0), std::make_shared<FailingMapFile>());
  int reads = 0, cancelled = 0;
  double furthest = 0;
  for (int allowed = 3;; allowed += 20) {
    int told = 0;
    double last = 0;
    const auto map =
        composer.Compose(1, Placed(submaps), ReaderOf(submaps, &reads), [&](double share) {
          EXPECT_GE(share, last);
          last = share;
          return ++told < allowed;
        });
    furthest = std::max(furthest, last);
    if (map.ok()) {
      Composer roomy(WithMemory(0));
      ExpectSame(**map, *Compose(&roomy, 1, submaps));
      break;
    }
    ASSERT_EQ(map.status().code(), absl::StatusCode::kCancelled) << map.status();
    ASSERT_LT(++cancelled, 100);
  }
  EXPECT_GT(cancelled, 1);
  EXPECT_DOUBLE_EQ(furthest, 1);
  EXPECT_EQ(reads, static_cast<int>(submaps.size()));
}

}  // namespace
}  // namespace isthmus::composition
