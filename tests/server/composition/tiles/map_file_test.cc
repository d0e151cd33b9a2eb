#include "server/composition/tiles/map_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "tests/server/composition/tiles/failing_map_file.h"

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

class MapFileTest : public ::testing::Test {
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

  FailingMapFile file_;
};

TEST_F(MapFileTest, WhatIsWrittenComesBack) {
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

TEST_F(MapFileTest, ShortAndInterruptedCallsGoOn) {
  file_.longest = 100;
  file_.interrupt_every = 3;
  const std::string bytes = Random(12345);
  const Extent extent = Write(bytes);
  EXPECT_EQ(Read(extent, 0, bytes.size()), bytes);
}

TEST_F(MapFileTest, FullDiskIsSaidAndTakesNothing) {
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

TEST_F(MapFileTest, SomeOfTheDiskIsLeftFree) {
  file_.free_bytes = FailingMapFile::kReserve + 3 * kGrain;
  const std::string bytes = Random(3 * kGrain);
  const Extent fits = Write(bytes);
  file_.free_bytes = FailingMapFile::kReserve;
  EXPECT_EQ(file_.Write(bytes.data(), 1).status().code(), absl::StatusCode::kResourceExhausted);
  file_.Free(fits);  // It may use its own space again.
  file_.free_bytes = FailingMapFile::kReserve + 3 * kGrain;
  EXPECT_EQ(Read(Write(bytes), 0, bytes.size()), bytes);
}

// A hole, whose room the disk may have given to others.
TEST_F(MapFileTest, FillingAHoleTakesRoomAsGrowingDoes) {
  const std::string bytes = Random(3 * kGrain);
  const Extent gone = Write(bytes), kept = Write("kept");
  file_.Free(gone);
  file_.free_bytes = FailingMapFile::kReserve + gone.size - 1;
  EXPECT_TRUE(absl::IsResourceExhausted(file_.Write(bytes.data(), bytes.size()).status()));
  EXPECT_EQ(file_.bytes_in_use(), kept.size);
  file_.free_bytes = FailingMapFile::kReserve + gone.size;
  const Extent filled = Write(bytes);
  EXPECT_EQ(filled.offset, gone.offset);
  EXPECT_EQ(Read(filled, 0, bytes.size()), bytes);
  EXPECT_EQ(Read(kept, 0, 4), "kept");
}

TEST_F(MapFileTest, WhatCannotBeReadIsDataLoss) {
  const std::string bytes = Random(10000);
  const Extent extent = Write(bytes);
  std::string back(bytes.size(), '\0');
  EXPECT_EQ(file_.Read(extent, 2 * kGrain, back.data(), bytes.size()).code(),
            absl::StatusCode::kDataLoss);  // Beyond the end.
  file_.fail_reads = true;
  EXPECT_EQ(file_.Read(extent, 0, back.data(), bytes.size()).code(), absl::StatusCode::kDataLoss);
}

class SavedMapFileTest : public ::testing::Test {
 protected:
  SavedMapFileTest() {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~SavedMapFileTest() override { std::filesystem::remove_all(folder_); }

  static Extent Write(MapFile* file, const std::string& bytes) {
    const auto extent = file->Write(bytes.data(), bytes.size());
    EXPECT_TRUE(extent.ok()) << extent.status();
    return extent.value_or(Extent());
  }
  static std::string Read(const MapFile& file, const Extent& extent, size_t size) {
    std::string bytes(size, '\0');
    const absl::Status status = file.Read(extent, 0, bytes.data(), size);
    return status.ok() ? bytes : status.ToString();
  }
  static std::string Saved(const std::string& folder) {
    return MapFile(folder, 0).TakeSaved(kMadeWith);
  }
  std::string PathOf(const std::string& name) const { return folder_ + "/" + name; }
  // Changes a byte, as a bad disk does.
  void Damage(const std::string& name, uint64_t at) const {
    std::fstream file(PathOf(name), std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(at));
    const char byte = static_cast<char>(file.get() ^ 1);
    file.seekp(static_cast<std::streamoff>(at));
    file.put(byte);
    ASSERT_TRUE(file.good());
  }

  static constexpr uint64_t kMadeWith = 7;
  const std::string folder_ = ::testing::TempDir() + "saved_map_" +
                              ::testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(SavedMapFileTest, GivesItsDiskBack) {
  MapFile file(folder_, 0);
  const Extent extent = Write(&file, "abc");
  EXPECT_EQ(file.bytes_in_use(), kGrain);
  file.Free(extent);
  EXPECT_EQ(file.bytes_in_use(), 0u);
  EXPECT_EQ(std::filesystem::file_size(PathOf("composed.points")), 0u);
}

TEST_F(SavedMapFileTest, TheNextFindsWhatWasSaved) {
  Extent a, b;
  {
    MapFile file(folder_, 0);
    EXPECT_EQ(file.TakeSaved(kMadeWith), "");
    a = Write(&file, "alpha");
    b = Write(&file, std::string(3 * kGrain, 'b'));
    Write(&file, "not saved");
    ASSERT_TRUE(file.Save(kMadeWith, "state", {b, a}).ok());
  }
  MapFile file(folder_, 0);
  EXPECT_EQ(file.TakeSaved(kMadeWith), "state");
  EXPECT_EQ(file.bytes_in_use(), 4 * kGrain);
  EXPECT_EQ(Read(file, a, 5), "alpha");
  EXPECT_EQ(Read(file, b, 3 * kGrain), std::string(3 * kGrain, 'b'));
  const Extent later = Write(&file, "gamma");
  EXPECT_EQ(Read(file, a, 5), "alpha");
  EXPECT_EQ(Read(file, later, 5), "gamma");
}

TEST_F(SavedMapFileTest, NothingStaysOnTheDiskOfWhatIsFree) {
  const std::string secret = "points of a session that was deleted";
  MapFile file(folder_, 0);
  const Extent gone = Write(&file, secret), stays = Write(&file, "stays");
  ASSERT_TRUE(file.Save(kMadeWith, "both", {gone, stays}).ok());
  file.Free(gone);
  const auto bytes = [this] { return io::ReadFile(PathOf("composed.points")).value_or(""); };
  EXPECT_THAT(bytes(), ::testing::HasSubstr(secret));  // The saved map needs it still.
  ASSERT_TRUE(file.Save(kMadeWith, "one", {stays}).ok());
  EXPECT_THAT(bytes(), ::testing::Not(::testing::HasSubstr(secret)));
  EXPECT_EQ(Read(file, stays, 5), "stays");
}

TEST_F(SavedMapFileTest, NothingIsFoundOfWhatWasMadeOtherwise) {
  {
    MapFile file(folder_, 0);
    ASSERT_TRUE(file.Save(kMadeWith, "state", {Write(&file, "alpha")}).ok());
  }
  MapFile file(folder_, 0);
  EXPECT_EQ(file.TakeSaved(kMadeWith + 1), "");
  const Extent mine = Write(&file, "mine");  // The old index must not name it.
  EXPECT_FALSE(std::filesystem::exists(PathOf("composed.index")));
  EXPECT_EQ(Read(file, mine, 4), "mine");
}

// A copy of the folder is what a crash at that moment leaves.
TEST_F(SavedMapFileTest, ACrashAtAnyMomentLeavesWhatWasSavedLast) {
  constexpr int kSaveEvery = 7;
  std::mt19937 rng(3);
  MapFile file(folder_, 0);
  std::vector<std::pair<Extent, std::string>> now, saved;
  const std::string copy = folder_ + "_copy";
  for (int step = 0; step < 60; ++step) {
    if (now.size() > 4) {
      std::swap(now[rng() % now.size()], now.back());
      file.Free(now.back().first);
      now.pop_back();
    }
    const std::string bytes(1 + rng() % (3 * kGrain), static_cast<char>('a' + rng() % 26));
    now.emplace_back(Write(&file, bytes), bytes);
    if (step % kSaveEvery == 0) {
      std::vector<Extent> extents;
      extents.reserve(now.size());
      for (const auto& [extent, unused] : now) extents.push_back(extent);
      ASSERT_TRUE(file.Save(kMadeWith, std::to_string(step), extents).ok());
      saved = now;
    }
    std::filesystem::remove_all(copy);
    std::filesystem::copy(folder_, copy);
    MapFile after(copy, 0);
    ASSERT_EQ(after.TakeSaved(kMadeWith), std::to_string(step / kSaveEvery * kSaveEvery));
    for (const auto& [extent, expected] : saved) {
      ASSERT_EQ(Read(after, extent, expected.size()), expected) << step;
    }
  }
  std::filesystem::remove_all(copy);
}

TEST_F(SavedMapFileTest, ADamagedPieceIsSaidAndSpoilsNoOther) {
  Extent good, bad;
  {
    MapFile file(folder_, 0);
    good = Write(&file, "good");
    bad = Write(&file, std::string(2 * kGrain, 'b'));
    ASSERT_TRUE(file.Save(kMadeWith, "state", {good, bad}).ok());
  }
  Damage("composed.points", bad.offset + kGrain + 1);
  {
    MapFile file(folder_, 0);
    ASSERT_EQ(file.TakeSaved(kMadeWith), "state");
    EXPECT_EQ(Read(file, good, 4), "good");
    char byte = 0;
    const absl::Status status = file.Read(bad, 0, &byte, 1);  // Though that byte is sound.
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
    EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("is damaged"));
    file.Free(bad);
    EXPECT_TRUE(file.Save(kMadeWith, "without", {good}).ok());
  }
  MapFile file(folder_, 0);
  EXPECT_EQ(file.TakeSaved(kMadeWith), "without");
  EXPECT_EQ(Read(file, good, 4), "good");
}

// A pipe would be waited for.
TEST_F(SavedMapFileTest, InPlaceOfWhatIsNoFileAnUnnamedOneServes) {
  namespace fs = std::filesystem;
  const std::map<std::string, std::function<void(const fs::path&)>> kinds = {
      {"pipe", [](const fs::path& path) { ASSERT_EQ(mkfifo(path.c_str(), 0600), 0); }},
      {"folder", [](const fs::path& path) { fs::create_directory(path); }},
      {"link", [](const fs::path& path) { fs::create_symlink("/etc/hostname", path); }}};
  for (const char* name : {"composed.points", "composed.index"}) {
    for (const auto& [kind, make] : kinds) {
      SCOPED_TRACE(std::string(name) + " is a " + kind);
      make(PathOf(name));
      MapFile file(folder_, 0);
      EXPECT_EQ(file.TakeSaved(kMadeWith), "");
      const absl::Status kept = file.kept();
      EXPECT_TRUE(absl::IsFailedPrecondition(kept)) << kept;
      EXPECT_THAT(std::string(kept.message()),
                  ::testing::AllOf(::testing::HasSubstr(PathOf(name)),
                                   ::testing::HasSubstr("remove it while no server runs:")));
      if (kind == "link") {
        EXPECT_THAT(std::string(kept.message()), ::testing::HasSubstr("is a link"));
      }
      const Extent extent = Write(&file, "alpha");
      EXPECT_EQ(Read(file, extent, 5), "alpha");
      EXPECT_EQ(file.Save(kMadeWith, "state", {extent}), kept);
      EXPECT_NE(fs::symlink_status(PathOf(name)).type(), fs::file_type::regular);
      fs::remove_all(PathOf(name));
    }
  }
}

TEST_F(SavedMapFileTest, OfADamagedOrCutIndexNothingIsTaken) {
  {
    MapFile file(folder_, 0);
    ASSERT_TRUE(file.Save(kMadeWith, "state", {Write(&file, "alpha")}).ok());
  }
  const uint64_t size = std::filesystem::file_size(PathOf("composed.index"));
  for (uint64_t at = 0; at < size; ++at) {
    Damage("composed.index", at);
    ASSERT_EQ(Saved(folder_), "") << at;
    Damage("composed.index", at);  // As it was.
  }
  EXPECT_EQ(Saved(folder_), "state");
  std::filesystem::resize_file(PathOf("composed.points"), 3);
  EXPECT_EQ(Saved(folder_), "");
  std::filesystem::resize_file(PathOf("composed.index"), size - 1);
  EXPECT_EQ(Saved(folder_), "");
}

TEST_F(SavedMapFileTest, ASecondOneLeavesTheFirstAlone) {
  MapFile first(folder_, 0);
  const Extent mine = Write(&first, "mine");
  ASSERT_TRUE(first.Save(kMadeWith, "first", {mine}).ok());
  {
    MapFile second(folder_, 0);
    EXPECT_EQ(second.TakeSaved(kMadeWith), "");
    const Extent its = Write(&second, "another");
    EXPECT_EQ(Read(second, its, 7), "another");
    const absl::Status status = second.Save(kMadeWith, "second", {its});
    EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  }
  EXPECT_EQ(Read(first, mine, 4), "mine");
  const std::string copy = folder_ + "_copy";
  std::filesystem::copy(folder_, copy);
  EXPECT_EQ(Saved(copy), "first");
  std::filesystem::remove_all(copy);
}

TEST_F(SavedMapFileTest, AFullDiskLeavesWhatWasSaved) {
  {
    FailingMapFile file(folder_);
    ASSERT_TRUE(file.Save(kMadeWith, "state", {Write(&file, "alpha")}).ok());
    file.writes_left = 0;
    EXPECT_TRUE(absl::IsResourceExhausted(file.Write("beta", 4).status()));
  }
  EXPECT_EQ(Saved(folder_), "state");
}

TEST(MapFile, FolderThatIsNotThere) {
  MapFile file("/nowhere/at/all", 0);
  EXPECT_EQ(file.Write("abc", 3).status().code(), absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace isthmus::composition
