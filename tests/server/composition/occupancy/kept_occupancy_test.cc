// A kept OctoMap must give the bytes that a build from nothing gives, whatever came before.
#include "server/composition/occupancy/kept_occupancy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/formats/octomap_reader.h"
#include "tests/server/composition/test_maps.h"

namespace isthmus::composition {
namespace {

const OccupancyOptions kFine{.resolution_m = 0.2, .max_range_m = 12};

// Rows of submaps 8 m apart, each of two keyframes that see some hundred points around.
std::vector<LaidSubmap> Rows(int count, std::mt19937* rng) {
  std::vector<LaidSubmap> submaps;
  for (int i = 0; i < count; ++i) {
    const int row = i / 2;
    auto points = RandomPoints(rng, 200, MakeBox({-9, -9, -1}, {9, 9, 3}));
    LaidSubmap laid =
        MakeSubmap(i % 2 == 0 ? "alice" : "bob", static_cast<uint32_t>(i / 2), points,
                   Pose::FromXyzRpy(8 * row, i % 2 * 5, 0.1 * i, 0.01, 0.02, 0.3 * i));
    auto submap = std::make_shared<Submap>(*laid.submap);
    submap->keyframes.push_back({.T_submap_sensor = Pose(Eigen::Vector3d(1.3, 0.2, 0.1))});
    for (size_t p = submap->points.size() / 2; p < submap->points.size(); ++p) {
      submap->points[p].keyframe = 1;
    }
    laid.submap = std::move(submap);
    submaps.push_back(std::move(laid));
  }
  return submaps;
}

class Kept : public ::testing::TestWithParam<OccupancyFormat> {
 protected:
  // The cost for the submaps; expects what a build from nothing gives.
  KeptOccupancy::Cost Check(const std::vector<LaidSubmap>& submaps,
                            const OccupancyOptions& options = kFine, uint32_t component = 0) {
    KeptOccupancy::Cost cost;
    reads_ = 0;
    const auto file = kept_.Write(Placed(submaps), ReaderOf(submaps, &reads_), component,
                                  GetParam(), options, &cost);
    const auto fresh =
        WriteOccupancy(Placed(submaps), ReaderOf(submaps), component, GetParam(), options);
    EXPECT_TRUE(file.ok()) << file.status();
    EXPECT_TRUE(fresh.ok()) << fresh.status();
    EXPECT_TRUE(file.ok() && fresh.ok() && *file == *fresh);
    return cost;
  }

  std::mt19937 rng_{5};
  KeptOccupancy kept_{uint64_t{64} << 20};
  int reads_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Formats, Kept,
                         ::testing::Values(OccupancyFormat::kBinary, OccupancyFormat::kFull),
                         [](const auto& format) {
                           return format.param == OccupancyFormat::kBinary ? "bt" : "ot";
                         });

// The cubes of the file's leaves, in the order that they have by place.
using Cubes = std::vector<std::tuple<int32_t, int32_t, int32_t, int32_t, bool>>;

template <typename Leaves>
Cubes InOrder(const Leaves& leaves) {
  Cubes cubes;
  for (const VoxelCube& c : leaves) cubes.emplace_back(c.x, c.y, c.z, c.edge, c.is_occupied);
  std::sort(cubes.begin(), cubes.end());
  return cubes;
}

TEST(FreeSpaceTest, IsWhatTheBinaryFileHas) {
  std::mt19937 rng(5);
  const std::vector<LaidSubmap> submaps = Rows(6, &rng);
  OccupancyOptions part = kFine;
  part.region.box = MakeBox({-3.3, -50, 0.3}, {9.1, 50, 1.7});
  OccupancyOptions nowhere = kFine;
  nowhere.region.box = MakeBox({900, 900, 900}, {901, 901, 901});
  for (const OccupancyOptions& options : {kFine, part, nowhere}) {
    KeptOccupancy kept(0);
    const auto file =
        WriteOccupancy(Placed(submaps), ReaderOf(submaps), 0, OccupancyFormat::kBinary, options);
    ASSERT_TRUE(file.ok()) << file.status();
    std::vector<VoxelCube> leaves;
    const auto resolution_m = formats::ParseOctomapBinary(
        *file, [&leaves](const VoxelCube& leaf) { leaves.push_back(leaf); });
    ASSERT_TRUE(resolution_m.ok()) << resolution_m.status();
    const auto read = [&](uint64_t max_file_bytes) {
      return kept.Read(Placed(submaps), ReaderOf(submaps), 0, options, max_file_bytes);
    };
    const auto space = read(file->size());
    ASSERT_TRUE(space.ok()) << space.status();
    EXPECT_EQ(space->resolution_m, *resolution_m);
    EXPECT_EQ(InOrder(space->cubes), InOrder(leaves));
    const size_t head = file->find("data\n") + 5;
    EXPECT_TRUE(read(file->size() - head).ok());
    if (leaves.empty()) continue;
    EXPECT_TRUE(absl::IsResourceExhausted(read(file->size() - head - 1).status()));
  }
}

TEST_P(Kept, ReadsNothingWhereNothingChanged) {
  const auto submaps = Rows(8, &rng_);
  EXPECT_GT(Check(submaps).columns_cast, 0u);
  EXPECT_EQ(reads_, 8);
  EXPECT_EQ(Check(submaps).columns_cast, 0u);
  EXPECT_EQ(reads_, 0);
  EXPECT_GT(kept_.kept_bytes(), 1000u);
}

TEST_P(Kept, SubmapsThatComeInAnyOrder) {
  const auto all = Rows(12, &rng_);
  std::vector<size_t> arrivals(all.size());
  for (size_t i = 0; i < all.size(); ++i) arrivals[i] = i;
  std::shuffle(arrivals.begin(), arrivals.end(), rng_);
  for (size_t count = 1; count <= all.size(); ++count) {
    std::vector<size_t> there(arrivals.begin(), arrivals.begin() + static_cast<ptrdiff_t>(count));
    std::sort(there.begin(), there.end());
    std::vector<LaidSubmap> submaps;
    submaps.reserve(there.size());
    for (const size_t i : there) submaps.push_back(all[i]);
    Check(submaps);
  }
}

TEST_P(Kept, OneThatComesCastsOnlyWhatItReaches) {
  auto submaps = Rows(40, &rng_);
  const LaidSubmap last = submaps.back();
  submaps.pop_back();
  const auto all = Check(submaps).columns_cast;
  submaps.push_back(last);
  const auto cast = Check(submaps).columns_cast;
  EXPECT_GT(cast, 0u);
  EXPECT_LT(cast, all / 2);
  // It is the last in order: the kept columns are gone on with.
  EXPECT_EQ(reads_, 2) << "once for where it reaches, once to cast";
}

TEST_P(Kept, OneThatMovesAndComesBack) {
  const auto before = Rows(40, &rng_);
  auto moved = before;
  moved[3].T_map_submap = Pose(Eigen::Vector3d(0.4, 0.3, 0)) * moved[3].T_map_submap;
  const auto all = Check(before).columns_cast;
  const auto cast = Check(moved).columns_cast;
  EXPECT_GT(cast, 0u);
  EXPECT_LT(cast, all / 2);
  EXPECT_LT(reads_, 20) << "those that reach the same ground";
  EXPECT_GT(Check(before).columns_cast, 0u);
}

TEST_P(Kept, AllMove) {
  auto submaps = Rows(10, &rng_);
  Check(submaps);
  for (LaidSubmap& laid : submaps) {
    laid.T_map_submap = Pose::FromXyzRpy(1, 2, 0, 0, 0, 0.5) * laid.T_map_submap;
  }
  Check(submaps);
  EXPECT_EQ(reads_, 10) << "once each: nothing can be left";
}

TEST_P(Kept, ASessionThatGoes) {
  const auto both = Rows(20, &rng_);
  std::vector<LaidSubmap> one;
  for (size_t i = 0; i < both.size(); i += 2) one.push_back(both[i]);
  Check(both);
  Check(one);
  Check(both);
  Check({});
  Check(both);
}

TEST_P(Kept, AnotherOrderIsAnotherFile) {
  auto submaps = Rows(6, &rng_);
  Check(submaps);
  std::reverse(submaps.begin(), submaps.end());
  Check(submaps);
}

TEST_P(Kept, RegionsTakeWhatTheyNeedAndLeaveTheRest) {
  const auto submaps = Rows(40, &rng_);
  OccupancyOptions part = kFine;
  part.region.box = MakeBox({20, -3, -0.5}, {31, 4, 1.5});
  const auto few = Check(submaps, part).columns_cast;
  const auto rest = Check(submaps).columns_cast;
  EXPECT_GT(few, 0u);
  EXPECT_GT(rest, few);
  EXPECT_EQ(Check(submaps, part).columns_cast, 0u);
  OccupancyOptions round = kFine;
  round.region.has_sphere = true;
  round.region.center = {40, 2, 1};
  round.region.radius_m = 9.1;
  EXPECT_EQ(Check(submaps, round).columns_cast, 0u);
  OccupancyOptions askew = kFine;
  askew.region.shape = std::make_shared<OrientedBoxShape>(Pose::FromXyzRpy(60, 3, 0.5, 0.1, 0, 0.7),
                                                          Eigen::Vector3d(20, 11, 2));
  EXPECT_EQ(Check(submaps, askew).columns_cast, 0u);
}

TEST_P(Kept, ComponentsResolutionsAndRangesBesideEachOther) {
  auto submaps = Rows(8, &rng_);
  submaps[1].component = submaps[2].component = 1;
  OccupancyOptions coarse = kFine, near = kFine;
  coarse.resolution_m = 0.5;
  near.max_range_m = 6;
  for (int round = 0; round < 2; ++round) {
    for (const OccupancyOptions& options : {kFine, coarse, near}) {
      for (const uint32_t component : {0u, 1u, 2u}) {
        const auto cast = Check(submaps, options, component).columns_cast;
        EXPECT_EQ(cast > 0, round == 0 && component < 2);
      }
    }
  }
}

TEST_P(Kept, OneRobotBesideAll) {
  const auto submaps = Rows(8, &rng_);
  OccupancyOptions bob = kFine;
  bob.robot = RobotId("bob");
  std::vector<LaidSubmap> his;
  for (size_t i = 1; i < submaps.size(); i += 2) his.push_back(submaps[i]);
  for (int round = 0; round < 2; ++round) {
    EXPECT_EQ(Check(submaps).columns_cast > 0, round == 0);
    EXPECT_EQ(Check(submaps, bob).columns_cast > 0, round == 0);
    EXPECT_EQ(*kept_.Write(Placed(submaps), ReaderOf(submaps), 0, GetParam(), bob),
              *WriteOccupancy(Placed(his), ReaderOf(his), 0, GetParam(), kFine));
  }
}

TEST_P(Kept, WhatHasNoRoomIsCastAgain) {
  const auto submaps = Rows(20, &rng_);
  Check(submaps);
  const uint64_t bytes = kept_.kept_bytes();
  KeptOccupancy half(bytes / 2);
  const auto fresh = WriteOccupancy(Placed(submaps), ReaderOf(submaps), 0, GetParam(), kFine);
  for (int round = 0; round < 3; ++round) {
    EXPECT_EQ(*half.Write(Placed(submaps), ReaderOf(submaps), 0, GetParam(), kFine), *fresh);
    EXPECT_LE(half.kept_bytes(), bytes / 2);
    EXPECT_GT(half.kept_bytes(), bytes / 4);
  }
}

// A file may need more memory than there is for all its voxels at once.
TEST_P(Kept, CastInSeveralPasses) {
  const auto submaps = Rows(20, &rng_);
  Check(submaps);
  OccupancyOptions tight = kFine;
  tight.max_bytes = 8 * kept_.kept_bytes();
  int reads = 0;
  const auto file =
      WriteOccupancy(Placed(submaps), ReaderOf(submaps, &reads), 0, GetParam(), tight);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_GT(reads, 30);
  EXPECT_EQ(*file, *WriteOccupancy(Placed(submaps), ReaderOf(submaps), 0, GetParam(), kFine));
  tight.max_bytes = kept_.kept_bytes() / 2;
  EXPECT_EQ(
      WriteOccupancy(Placed(submaps), ReaderOf(submaps), 0, GetParam(), tight).status().code(),
      absl::StatusCode::kResourceExhausted);
}

TEST_P(Kept, OneThatCannotBeReadAnyMore) {
  const auto all = Rows(10, &rng_);
  Check(all);
  auto moved = all;
  moved[4].T_map_submap = Pose(Eigen::Vector3d(0.4, 0.3, 0)) * moved[4].T_map_submap;
  // A neighbour of the one that moved, which has to be read again.
  std::vector<LaidSubmap> there = moved;
  there.erase(there.begin() + 5);
  KeptOccupancy::Cost cost;
  const auto file = kept_.Write(Placed(moved), ReaderOf(there), 0, GetParam(), kFine, &cost);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(cost.missing, 1u);
  EXPECT_EQ(*file, *WriteOccupancy(Placed(there), ReaderOf(there), 0, GetParam(), kFine));
  Check(moved);  // It is asked for again.
}

TEST_P(Kept, EndsWhenToldTo) {
  const auto submaps = Rows(10, &rng_);
  OccupancyOptions options = kFine;
  int asked = 0;
  options.region.keep_on = [&asked] { return ++asked < 4; };
  EXPECT_EQ(kept_.Write(Placed(submaps), ReaderOf(submaps), 0, GetParam(), options).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_EQ(asked, 4);
  Check(submaps);
}

}  // namespace
}  // namespace isthmus::composition
