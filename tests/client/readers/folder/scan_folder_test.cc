#include "client/readers/folder/scan_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/codec/payload_builder.h"
#include "core/formats/pcd.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ScanFolderTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    root_ = fs::path(testing::TempDir()) / "isthmus_scan_folder" / info->name();
    fs::remove_all(root_);
    fs::create_directories(root_ / "scans");
  }

  // A KITTI scan whose only point has x = `mark`.
  void AddBin(const std::string& name, float mark) {
    const float record[4] = {mark, 0, 0, 0};
    std::ofstream(root_ / "scans" / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(record), sizeof(record));
  }
  void AddPcd(const std::string& name, uint16_t highest_ring, bool has_ring = true) {
    std::vector<ScanPoint> points(2);
    points[1].ring = highest_ring;
    ASSERT_TRUE(formats::WritePcd(root_ / "scans" / name,
                                  codec::MakePayload(points, has_ring, false),
                                  formats::PcdEncoding::kBinary)
                    .ok());
  }
  void Write(const std::string& name, const std::string& text) {
    std::ofstream(root_ / name) << text;
  }
  absl::StatusOr<ScanFolder> Open(const ScanFolderOptions& options = {}) const {
    return ScanFolder::Open((root_ / "scans").string(), options);
  }
  std::string Error(const ScanFolderOptions& options = {}) const {
    return std::string(Open(options).status().message());
  }

  fs::path root_;
};

float FirstX(const PointPayload& payload) {
  float x = 0;
  std::memcpy(&x, payload.data.data(), sizeof(x));
  return x;
}

TEST_F(ScanFolderTest, OrdersByNumberAndStampsByRate) {
  AddBin("10.bin", 10);
  AddBin("9.bin", 9);
  AddBin("11.bin", 11);
  const auto folder = Open({.rate_hz = 20});
  ASSERT_TRUE(folder.ok()) << folder.status();
  ASSERT_EQ(folder->size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(FirstX(*folder->Read(i)), 9 + i);
    EXPECT_EQ(folder->stamp_ns(i), static_cast<int64_t>(i) * 50'000'000);
  }
}

TEST_F(ScanFolderTest, ARangeKeepsTheStampsOfTheWholeFolder) {
  for (int i = 0; i < 10; ++i) AddBin(std::to_string(i) + ".bin", i);
  const auto folder = Open({.from = 4, .to = 6});
  ASSERT_TRUE(folder.ok()) << folder.status();
  ASSERT_EQ(folder->size(), 3u);
  EXPECT_EQ(FirstX(*folder->Read(0)), 4);
  EXPECT_EQ(folder->stamp_ns(0), 400'000'000);
  EXPECT_EQ(Open({.from = 8, .to = 99})->size(), 2u);
  EXPECT_THAT(Error({.from = 10}), HasSubstr("holds 10"));
  EXPECT_THAT(Error({.from = 5, .to = 4}), HasSubstr("no scans from 5 to 4"));
}

TEST_F(ScanFolderTest, TimesComeFromTheFolderElseFromBesideIt) {
  AddBin("0.bin", 0);
  AddBin("1.bin", 1);
  Write("times.txt", "5.0\n6.0\n");
  EXPECT_EQ(Open()->stamp_ns(1), 6'000'000'000);
  EXPECT_EQ(ScanFolder::Open((root_ / "scans/").string())->stamp_ns(1), 6'000'000'000);
  Write("scans/times.txt", "7.0\n8.0\n");
  EXPECT_EQ(Open()->stamp_ns(1), 8'000'000'000);
}

TEST_F(ScanFolderTest, SaysWhichTimesDoNotFit) {
  AddBin("0.bin", 0);
  Write("times.txt", "1\n2\n");
  EXPECT_THAT(Error(), testing::AllOf(HasSubstr("times.txt"), HasSubstr("2 times for 1 scans")));
  Write("times.txt", "one\n");
  EXPECT_THAT(Error(), testing::AllOf(HasSubstr("times.txt"), HasSubstr("line 1")));
}

TEST_F(ScanFolderTest, SaysWhatIsWrongWithAFolder) {
  EXPECT_TRUE(absl::IsNotFound(ScanFolder::Open("/no/such/folder").status()));
  EXPECT_THAT(Error(), HasSubstr("holds no scans"));
  AddBin("0.bin", 0);
  AddPcd("1.pcd", 15);
  EXPECT_THAT(Error(), HasSubstr("both .bin and .pcd"));
  EXPECT_THAT(Error({.rate_hz = 0}), HasSubstr("rate"));
}

TEST_F(ScanFolderTest, ADamagedScanIsNamedAndTheOthersCanBeRead) {
  AddBin("0.bin", 0);
  AddBin("1.bin", 1);
  Write("scans/0.bin", "seven b");
  const auto folder = Open();
  ASSERT_TRUE(folder.ok());
  EXPECT_THAT(std::string(folder->Read(0).status().message()), HasSubstr("0.bin"));
  EXPECT_TRUE(folder->Read(1).ok());
}

TEST_F(ScanFolderTest, GuessesTheSensor) {
  AddPcd("0.pcd", 15);
  EXPECT_EQ(*Open()->GuessSensor(), "vlp16");
  AddPcd("0.pcd", 63);
  EXPECT_EQ(*Open()->GuessSensor(), "hdl64");
  AddPcd("0.pcd", 0, /*has_ring=*/false);
  EXPECT_THAT(std::string(Open()->GuessSensor().status().message()), HasSubstr("--sensor"));
  Write("simulation.json", R"({"sensor": "os1-64"})");
  EXPECT_EQ(*Open()->GuessSensor(), "os1-64");
}

TEST_F(ScanFolderTest, KittiMeansHdl64) {
  AddBin("0.bin", 0);
  EXPECT_EQ(*Open()->GuessSensor(), "hdl64");
}

}  // namespace
}  // namespace isthmus::readers
