#include "server/composition/tiles/spill_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "tests/server/composition/tiles/failing_spill_file.h"

namespace isthmus::composition {
namespace {

constexpr uint64_t kGrain = ExtentAllocator::kGrain;

TEST(ExtentAllocator, SpaceGivenBackIsUsedAgain) {
  ExtentAllocator extents;
  const Extent a = extents.Allocate(1), b = extents.Allocate(kGrain + 1);
  const Extent c = extents.Allocate(kGrain);
  EXPECT_EQ(a.size, kGrain);
  EXPECT_EQ(b.size, 2 * kGrain);
  EXPECT_EQ(extents.end(), 4 * kGrain);
  extents.Free(a);
  extents.Free(b);  // Joins with a.
  EXPECT_EQ(extents.Allocate(3 * kGrain).offset, 0u);
  EXPECT_EQ(extents.end(), 4 * kGrain);
  extents.Free(c);
  EXPECT_EQ(extents.end(), 3 * kGrain);
}

TEST(ExtentAllocator, StretchesNeverOverlap) {
  std::mt19937 rng(5);
  ExtentAllocator extents;
  std::vector<Extent> used;
  for (int step = 0; step < 3000; ++step) {
    if (used.empty() || rng() % 2 == 0) {
      used.push_back(extents.Allocate(1 + rng() % (9 * kGrain)));
    } else {
      std::swap(used[rng() % used.size()], used.back());
      extents.Free(used.back());
      used.pop_back();
    }
    std::map<uint64_t, uint64_t> by_offset;
    uint64_t sum = 0;
    for (const Extent& extent : used) {
      by_offset[extent.offset] = extent.size;
      sum += extent.size;
    }
    uint64_t end = 0;
    for (const auto& [offset, size] : by_offset) {
      ASSERT_GE(offset, end);
      end = offset + size;
    }
    ASSERT_EQ(by_offset.size(), used.size());
    ASSERT_EQ(extents.end(), end);
    ASSERT_EQ(extents.in_use(), sum);
  }
}

class SpillFileTest : public ::testing::Test {
 protected:
  static std::string Random(size_t size) {
    static std::mt19937 rng(7);
    std::string bytes(size, '\0');
    for (char& byte : bytes) byte = static_cast<char>(rng());
    return bytes;
  }
  Extent Write(const std::string& bytes) {
    const auto extent = file_.Write(bytes.data(), bytes.size());
    EXPECT_TRUE(extent.ok()) << extent.status();
    return extent.ok() ? *extent : Extent();
  }
  std::string Read(const Extent& extent, uint64_t from, size_t size) {
    std::string bytes(size, '\0');
    const absl::Status status = file_.Read(extent, from, bytes.data(), size);
    EXPECT_TRUE(status.ok()) << status;
    return bytes;
  }

  FailingSpillFile file_;
};

TEST_F(SpillFileTest, WhatIsWrittenComesBack) {
  std::mt19937 rng(6);
  std::vector<std::pair<std::string, Extent>> kept;
  for (int step = 0; step < 200; ++step) {
    if (kept.size() > 10) {
      std::swap(kept[rng() % kept.size()], kept.back());
      file_.Free(kept.back().second);
      kept.pop_back();
    }
    const std::string bytes = Random(1 + rng() % 20000);
    kept.emplace_back(bytes, Write(bytes));
    for (const auto& [expected, extent] : kept) {
      ASSERT_EQ(Read(extent, 0, expected.size()), expected);
    }
  }
  const auto& [bytes, extent] = kept.front();
  EXPECT_EQ(Read(extent, bytes.size() / 2, bytes.size() / 3),
            bytes.substr(bytes.size() / 2, bytes.size() / 3));
}

TEST_F(SpillFileTest, ShortAndInterruptedCallsGoOn) {
  file_.longest = 100;
  file_.interrupt_every = 3;
  const std::string bytes = Random(12345);
  const Extent extent = Write(bytes);
  EXPECT_EQ(Read(extent, 0, bytes.size()), bytes);
}

TEST_F(SpillFileTest, FullDiskIsSaidAndTakesNothing) {
  const std::string bytes = Random(50000);
  const Extent kept = Write(bytes);
  const uint64_t before = file_.bytes_in_use();
  file_.longest = 1000;
  file_.writes_left = 10;  // Full half way.
  const auto full = file_.Write(bytes.data(), bytes.size());
  EXPECT_EQ(full.status().code(), absl::StatusCode::kResourceExhausted) << full.status();
  EXPECT_EQ(file_.bytes_in_use(), before);
  file_.writes_left = 1 << 30;
  const Extent later = Write(bytes);
  EXPECT_EQ(Read(kept, 0, bytes.size()), bytes);
  EXPECT_EQ(Read(later, 0, bytes.size()), bytes);
}

TEST_F(SpillFileTest, SomeOfTheDiskIsLeftFree) {
  file_.free_bytes = FailingSpillFile::kReserve + 3 * kGrain;
  const std::string bytes = Random(3 * kGrain);
  const Extent fits = Write(bytes);
  file_.free_bytes = FailingSpillFile::kReserve;
  EXPECT_EQ(file_.Write(bytes.data(), 1).status().code(), absl::StatusCode::kResourceExhausted);
  file_.Free(fits);  // It may use its own space again.
  file_.free_bytes = FailingSpillFile::kReserve + 3 * kGrain;
  EXPECT_EQ(Read(Write(bytes), 0, bytes.size()), bytes);
}

TEST_F(SpillFileTest, WhatCannotBeReadIsDataLoss) {
  const std::string bytes = Random(10000);
  const Extent extent = Write(bytes);
  std::string back(bytes.size(), '\0');
  EXPECT_EQ(file_.Read(extent, 2 * kGrain, back.data(), bytes.size()).code(),
            absl::StatusCode::kDataLoss);  // Beyond the end.
  file_.fail_reads = true;
  EXPECT_EQ(file_.Read(extent, 0, back.data(), bytes.size()).code(), absl::StatusCode::kDataLoss);
}

TEST(SpillFile, LeavesNoNameAndGivesItsDiskBack) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "isthmus_spill_folder";
  std::filesystem::create_directories(folder);
  SpillFile file(folder, 0);
  const auto extent = file.Write("abc", 3);
  ASSERT_TRUE(extent.ok()) << extent.status();
  EXPECT_TRUE(std::filesystem::is_empty(folder));
  EXPECT_EQ(file.bytes_in_use(), kGrain);
  file.Free(*extent);
  EXPECT_EQ(file.bytes_in_use(), 0u);
  std::filesystem::remove(folder);
}

TEST(SpillFile, FolderThatIsNotThere) {
  SpillFile file("/nowhere/at/all", 0);
  EXPECT_EQ(file.Write("abc", 3).status().code(), absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace isthmus::composition
