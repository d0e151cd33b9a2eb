#include "client/readers/folder/folder_recording.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "client/readers/started_reader.h"
#include "core/codec/payload_builder.h"
#include "core/codec/scan_decoder.h"
#include "core/formats/pcd.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;

class FolderRecordingTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    root_ = fs::path(testing::TempDir()) / "isthmus_folder_recording" / info->name();
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
  // Everything that the folder gives, or why it cannot be opened.
  struct Read {
    absl::Status status;
    std::vector<RecordedScan> scans;
    std::vector<std::string> errors, assumptions;
    std::string sensor;
  };
  Read ReadAll(const ReadOptions& options = {}, const std::string& folder = "scans") const {
    Read read;
    const auto recording = OpenFolderRecording((root_ / folder).string());
    if (!recording.ok()) return {recording.status(), {}, {}, {}, ""};
    auto reader = (*recording)->OpenScans(0, options);
    if (!reader.ok()) return {reader.status(), {}, {}, {}, ""};
    StartedReader started(*std::move(reader));
    read.sensor = started.sensor();
    for (;;) {
      absl::StatusOr<std::optional<RecordedScan>> scan = started.Next();
      if (!scan.ok()) {
        read.errors.emplace_back(scan.status().message());
      } else if (scan->has_value()) {
        read.scans.push_back(**std::move(scan));
      } else {
        break;
      }
    }
    read.assumptions = started.Assumptions();
    return read;
  }
  std::string Error(const ReadOptions& options = {}) const {
    return std::string(ReadAll(options).status.message());
  }

  fs::path root_;
};

float FirstX(const PointPayload& payload) {
  float x = 0;
  std::memcpy(&x, payload.data.data(), sizeof(x));
  return x;
}

TEST_F(FolderRecordingTest, OrdersByNumberAndStampsByRate) {
  AddBin("10.bin", 10);
  AddBin("9.bin", 9);
  AddBin("11.bin", 11);
  const Read read = ReadAll({.rate_hz = 20});
  ASSERT_EQ(read.scans.size(), 3u) << read.status;
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(FirstX(read.scans[i].payload), 9 + i);
    EXPECT_EQ(read.scans[i].end_stamp_ns, static_cast<int64_t>(i) * 50'000'000);
  }
  EXPECT_THAT(read.assumptions, Contains(HasSubstr("scan i ended at i / 20 seconds")));
}

// The times of the points of a scan, as the decoder reads them; empty where it has none.
std::vector<float> Times(const RecordedScan& scan) {
  const auto decoded = codec::DecodeScan(scan.payload, 1, scan.end_stamp_ns);
  EXPECT_TRUE(decoded.ok()) << decoded.status();
  std::vector<float> times;
  if (!decoded.ok() || !decoded->has_time) return times;
  for (const ScanPoint& point : decoded->points) times.push_back(point.time);
  return times;
}

TEST_F(FolderRecordingTest, WhatIsCompensatedHasTimesOfZero) {
  std::vector<ScanPoint> points(3);
  for (size_t i = 0; i < 3; ++i) points[i] = {.x = 5, .time = -0.05F * static_cast<float>(i)};
  ASSERT_TRUE(formats::WritePcd(root_ / "scans/1700000000.5.pcd",
                                codec::MakePayload(points, false, true),
                                formats::PcdEncoding::kBinary)
                  .ok());
  EXPECT_THAT(Times(ReadAll().scans.at(0)), testing::ElementsAre(0, -0.05F, -0.1F));
  EXPECT_EQ(ReadAll().scans[0].end_stamp_ns, 1'700'000'000'500'000'000);
  for (const StampMeaning meaning : {StampMeaning::kByTimes, StampMeaning::kStart}) {
    const Read read = ReadAll({.stamps = meaning, .compensated = true});
    EXPECT_THAT(Times(read.scans.at(0)), testing::ElementsAre(0, 0, 0));
    EXPECT_EQ(read.scans[0].end_stamp_ns, 1'700'000'000'500'000'000);
    EXPECT_THAT(read.assumptions, Contains(HasSubstr("motion-compensated already")));
  }
}

TEST_F(FolderRecordingTest, TimesThatAreAllZeroSaySo) {
  for (const char* name : {"0.pcd", "1.pcd"}) {
    std::vector<ScanPoint> points(3);
    for (ScanPoint& p : points) p.x = 5;
    ASSERT_TRUE(formats::WritePcd(root_ / "scans" / name, codec::MakePayload(points, false, true),
                                  formats::PcdEncoding::kBinary)
                    .ok());
  }
  EXPECT_THAT(Times(ReadAll().scans.at(1)), testing::ElementsAre(0, 0, 0));
  EXPECT_THAT(ReadAll().assumptions, Contains(HasSubstr("motion-compensated already")));
  const Read raw = ReadAll({.compensated = false});
  EXPECT_THAT(Times(raw.scans.at(1)), testing::IsEmpty());
  EXPECT_THAT(raw.assumptions, testing::Not(Contains(HasSubstr("motion-compensated"))));
}

TEST_F(FolderRecordingTest, EmptyTimesOfTheFirstScansDoNotMakeADriveCompensated) {
  for (int i = 0; i < 14; ++i) {
    std::vector<ScanPoint> points(3);
    for (size_t k = 0; k < 3; ++k) {
      points[k] = {.x = 5, .time = i < 10 || i == 12 ? 0 : -0.1F + 0.05F * static_cast<float>(k)};
    }
    ASSERT_TRUE(formats::WritePcd(root_ / "scans" / absl::StrCat(i, ".pcd"),
                                  codec::MakePayload(points, false, true),
                                  formats::PcdEncoding::kBinary)
                    .ok());
  }
  const Read read = ReadAll();
  ASSERT_EQ(read.scans.size(), 14u) << read.status;
  EXPECT_THAT(read.assumptions,
              Contains(HasSubstr("points of the first 10 scans have times of 0 alone")));
  EXPECT_THAT(read.assumptions, testing::Not(Contains(HasSubstr("motion-compensated already"))));
  codec::ScanDecoder decoder;
  for (size_t i = 0; i < 14; ++i) {
    const auto decoded = decoder.Decode(read.scans[i].payload, 1, read.scans[i].end_stamp_ns);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    const bool has_true_times = i >= 10 && i != 12;
    EXPECT_EQ(decoded->has_time && decoded->points.front().time < 0, has_true_times) << i;
  }
}

TEST_F(FolderRecordingTest, TimesThatGoBackAreThoseOfAClockThatWasSet) {
  for (int i = 0; i < 4; ++i) AddBin(absl::StrCat(i, ".bin"), 5);
  Write("times.txt", "100\n100.1\n40\n40.1\n");
  const Read read = ReadAll();
  ASSERT_EQ(read.scans.size(), 4u) << read.status;
  EXPECT_EQ(read.scans[1].end_stamp_ns, 100'100'000'000);
  EXPECT_EQ(read.scans[2].end_stamp_ns, 40'000'000'000);
}

TEST_F(FolderRecordingTest, AUnixClockOfThePointsStampsScansThatNothingElseStamps) {
  // Scans 0, 1, 2 and, after a gap of 7 s, 3. Their clock counts seconds, END 0.1 s behind the
  // first.
  const double ends_s[] = {1.7e9, 1.7e9 + 0.1, 1.7e9 + 0.2, 1.7e9 + 7.3};
  for (int i = 0; i < 4; ++i) {
    std::string rows =
        "VERSION .7\nFIELDS x y z timestamp\nSIZE 4 4 4 8\nTYPE F F F F\n"
        "COUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA ascii\n";
    for (int k = 0; k < 3; ++k) {
      absl::StrAppend(&rows, 5 + k, absl::StrFormat(" 1 0 %.6f\n", ends_s[i] - 0.1 + 0.05 * k));
    }
    Write(absl::StrCat("scans/", i, ".pcd"), rows);
  }
  const Read read = ReadAll();
  ASSERT_EQ(read.scans.size(), 4u) << read.status;
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(1e-9 * static_cast<double>(read.scans[i].end_stamp_ns), ends_s[i], 1e-5) << i;
  }
  EXPECT_THAT(read.assumptions, Contains(HasSubstr("the points' clock")));
  EXPECT_THAT(read.assumptions, testing::Not(Contains(HasSubstr("scan i ended at"))));
  // Times of points that were moved to an instant mean nothing.
  EXPECT_EQ(ReadAll({.compensated = true}).scans.at(3).end_stamp_ns, 300'000'000);
}

TEST_F(FolderRecordingTest, ScansThatAreThereTwiceAreLeftOutOnce) {
  for (const char* name : {"1700000000.1.bin", "1700000000.2.bin", "1700000000.3.bin"}) {
    AddBin(name, static_cast<float>(name[11]));
  }
  Write("times.txt", "1\n1\n2\n");
  fs::copy_file(root_ / "scans/1700000000.1.bin", root_ / "scans/1700000000.2.bin",
                fs::copy_options::overwrite_existing);
  const Read read = ReadAll();
  ASSERT_EQ(read.scans.size(), 2u) << read.status;
  EXPECT_EQ(read.scans[1].end_stamp_ns, 2'000'000'000);
  EXPECT_THAT(read.assumptions, Contains(HasSubstr("1 scan is in the recording twice")));
  // A robot that stands in a world without noise sees the same again, later.
  Write("times.txt", "1\n1.5\n2\n");
  EXPECT_EQ(ReadAll().scans.size(), 3u);
}

TEST_F(FolderRecordingTest, DrivesOfKittisOdometryAreCompensated) {
  for (int i = 0; i < 2; ++i) AddBin(std::to_string(i) + ".bin", 5);
  fs::rename(root_ / "scans", root_ / "velodyne");
  Write("times.txt", "0.0\n0.1\n");
  EXPECT_THAT(Times(ReadAll({}, ".").scans.at(1)), testing::IsEmpty());
  Write("calib.txt", "P0: 1 0 0 0 0 1 0 0 0 0 1 0\n");
  for (const char* folder : {".", "velodyne", "velodyne/"}) {
    const Read read = ReadAll({}, folder);
    EXPECT_THAT(Times(read.scans.at(1)), testing::ElementsAre(0)) << folder;
    EXPECT_EQ(read.scans[1].end_stamp_ns, 100'000'000);
    EXPECT_THAT(read.assumptions, Contains(HasSubstr("motion-compensated already")));
    EXPECT_THAT(Times(ReadAll({.compensated = false}, folder).scans.at(1)), testing::IsEmpty());
  }
}

TEST_F(FolderRecordingTest, ARangeKeepsTheStampsOfTheWholeFolder) {
  for (int i = 0; i < 10; ++i) AddBin(std::to_string(i) + ".bin", i);
  const Read read = ReadAll({.from = 4, .to = 6});
  ASSERT_EQ(read.scans.size(), 3u) << read.status;
  EXPECT_EQ(FirstX(read.scans[0].payload), 4);
  EXPECT_EQ(read.scans[0].end_stamp_ns, 400'000'000);
  EXPECT_EQ(ReadAll({.from = 8, .to = 99}).scans.size(), 2u);
  EXPECT_THAT(Error({.from = 10}), HasSubstr("holds 10"));
  EXPECT_THAT(Error({.from = 5, .to = 4}), HasSubstr("no scans from 5 to 4"));
}

TEST_F(FolderRecordingTest, TimesComeFromTheFolderElseFromBesideIt) {
  AddBin("0.bin", 0);
  AddBin("1.bin", 1);
  Write("times.txt", "5.0\n6.0\n");
  EXPECT_EQ(ReadAll().scans[1].end_stamp_ns, 6'000'000'000);
  EXPECT_EQ(ReadAll({}, "scans/").scans[1].end_stamp_ns, 6'000'000'000);
  Write("scans/times.txt", "7.0\n8.0\n");
  EXPECT_EQ(ReadAll().scans[1].end_stamp_ns, 8'000'000'000);
}

TEST_F(FolderRecordingTest, ReadsKittisRawDrives) {
  fs::create_directories(root_ / "drive/velodyne_points/data");
  for (const char* name : {"0000000000.bin", "0000000001.bin"}) {
    AddBin(name, 0);
    fs::rename(root_ / "scans" / name, root_ / "drive/velodyne_points/data" / name);
  }
  Write("drive/velodyne_points/timestamps.txt",
        "2011-09-26 13:02:25.100000001\n2011-09-26 13:02:25.200000001\n");
  const Read middle = ReadAll({}, "drive");
  ASSERT_EQ(middle.scans.size(), 2u) << middle.status;
  EXPECT_EQ(middle.scans[0].end_stamp_ns, 1317042145'150'000'001);
  EXPECT_THAT(middle.assumptions, Contains(HasSubstr("half a turn after")));
  Write("drive/velodyne_points/timestamps_end.txt",
        "2011-09-26 13:02:25.140000001\n2011-09-26 13:02:25.240000001\n");
  EXPECT_EQ(ReadAll({}, "drive").scans[0].end_stamp_ns, 1317042145'140'000'001);
  EXPECT_EQ(ReadAll({}, "drive/velodyne_points/data").scans[1].end_stamp_ns,
            1317042145'240'000'001);
}

TEST_F(FolderRecordingTest, NamesMayBeStamps) {
  AddPcd("1305031102.175304000.pcd", 15);
  AddPcd("1305031102.275304001.pcd", 15);
  const Read read = ReadAll();
  ASSERT_EQ(read.scans.size(), 2u) << read.status;
  EXPECT_EQ(read.scans[1].end_stamp_ns, 1305031102'275'304'001);
  EXPECT_THAT(read.assumptions, Contains(HasSubstr("names of the files")));
}

TEST_F(FolderRecordingTest, NamesInMicrosecondsMayBeStamps) {
  AddPcd("1305031102175304.pcd", 15);
  AddPcd("1305031102275304.pcd", 15);
  EXPECT_EQ(ReadAll().scans.at(1).end_stamp_ns, 1305031102'275'304'000);
}

TEST_F(FolderRecordingTest, NamesOfAFarFutureOnlyCount) {
  for (const char* name : {"9999999999999.pcd", "9999999999999999.pcd", "9999999999.5.pcd"}) {
    AddPcd(name, 15);
    EXPECT_EQ(ReadAll().scans.at(0).end_stamp_ns, 0) << name;
    fs::remove(root_ / "scans" / name);
  }
}

TEST_F(FolderRecordingTest, WhatDoesNotFitTheSeriesIsLeftOutAndNamed) {
  for (int i = 8; i < 12; ++i) AddPcd("full" + std::to_string(i) + ".pcd", 15);
  AddPcd("map_final.pcd", 15);
  AddPcd("._full8.pcd", 15);
  Write("scans/merged.ply", "not even a cloud");
  const Read read = ReadAll();
  ASSERT_EQ(read.scans.size(), 4u) << read.status;
  EXPECT_THAT(read.scans[2].name, HasSubstr("full10.pcd"));
  EXPECT_THAT(read.assumptions, Contains(testing::AllOf(HasSubstr("full#.pcd"),
                                                        HasSubstr("._full8.pcd, map_final.pcd, "
                                                                  "merged.ply"))));
}

TEST_F(FolderRecordingTest, MissingNumbersAreGapsInTime) {
  for (const int i : {4, 5, 6, 9, 10, 12}) AddBin("scan_" + std::to_string(i) + ".bin", i);
  const Read steps = ReadAll();
  ASSERT_EQ(steps.scans.size(), 6u) << steps.status;
  EXPECT_EQ(steps.scans[3].end_stamp_ns, 300'000'000) << "not three in five: keyframes";
  for (const int i : {13, 14, 15}) AddBin("scan_" + std::to_string(i) + ".bin", i);
  const Read read = ReadAll();
  ASSERT_EQ(read.scans.size(), 9u) << read.status;
  EXPECT_EQ(read.scans[3].end_stamp_ns, 500'000'000);
  EXPECT_EQ(read.scans.back().end_stamp_ns, 1'100'000'000);
  EXPECT_THAT(read.assumptions, Contains(HasSubstr("3 numbers are missing from the names, the "
                                                   "first before scan_9.bin")));
}

TEST_F(FolderRecordingTest, TimesOfAllNumbersFitAFolderThatLacksSome) {
  for (const char* name : {"0.bin", "1.bin", "2.bin", "3.bin", "5.bin"}) AddBin(name, 0);
  Write("times.txt", "10\n11\n12\n13\n14\n15\n");
  const Read read = ReadAll();
  ASSERT_EQ(read.scans.size(), 5u) << read.status;
  EXPECT_EQ(read.scans.back().end_stamp_ns, 15'000'000'000);
}

TEST_F(FolderRecordingTest, TimesOfATrajectoryAreNotForcedOnTheClouds) {
  AddPcd("2021-10-26-16-21-29-468.pcd", 15);
  AddPcd("2021-10-26-16-21-29-568.pcd", 15);
  Write("times.txt", "1\n2\n3\n");
  EXPECT_THAT(Error(), HasSubstr("3 times for 2 scans")) << "may be meant for the clouds";
  Write("trajectory.kitti",
        "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n1 0 0 2 0 1 0 0 0 0 1 0\n");
  const Read read = ReadAll();
  ASSERT_EQ(read.scans.size(), 2u) << read.status;
  EXPECT_EQ(read.scans[1].end_stamp_ns, 1635265289'568'000'000);
  EXPECT_THAT(read.assumptions,
              Contains(testing::AllOf(HasSubstr("times.txt"), HasSubstr("trajectory.kitti"))));
}

TEST_F(FolderRecordingTest, ReadsRowsOfNumbersWhereThereIsNothingElse) {
  Write("scans/1.txt", "1 2 3\n");
  Write("scans/poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n");
  const Read read = ReadAll();
  ASSERT_EQ(read.scans.size(), 1u) << read.status;
  EXPECT_EQ(read.scans[0].payload.width, 1u);
  Write("scans/2.txt", "1 2 3\n");
  Write("scans/2021-10-26-16-21-29-468.txt", "1 2 3\n");
  EXPECT_THAT(ReadAll().assumptions, Contains(HasSubstr("2021-10-26"))) << "not of the series";
  AddBin("0.bin", 0);
  EXPECT_THAT(ReadAll().scans.at(0).name, HasSubstr("0.bin")) << "a text may be anything";
}

TEST_F(FolderRecordingTest, AFileIsARecordingOfOneScan) {
  AddPcd("0.pcd", 15);
  AddPcd("1.pcd", 15);
  EXPECT_EQ(ReadAll({}, "scans/1.pcd").scans.size(), 1u);
}

TEST_F(FolderRecordingTest, SaysWhichTimesDoNotFit) {
  AddBin("0.bin", 0);
  Write("times.txt", "1\n2\n");
  EXPECT_THAT(Error(), testing::AllOf(HasSubstr("times.txt"), HasSubstr("2 times for 1 scans")));
  Write("times.txt", "one\n");
  EXPECT_THAT(Error(), testing::AllOf(HasSubstr("times.txt"), HasSubstr("line 1")));
}

TEST_F(FolderRecordingTest, SaysWhatIsWrongWithAFolder) {
  EXPECT_TRUE(absl::IsNotFound(OpenFolderRecording("/no/such/folder").status()));
  EXPECT_THAT(Error(), HasSubstr("holds no scans"));
  AddBin("0.bin", 0);
  AddPcd("1.pcd", 15);
  EXPECT_THAT(Error(), HasSubstr("both .bin and .pcd"));
  fs::remove(root_ / "scans/1.pcd");
  EXPECT_THAT(Error({.rate_hz = 0}), HasSubstr("rate"));
}

TEST_F(FolderRecordingTest, ADamagedScanIsNamedAndTheOthersCanBeRead) {
  AddBin("0.bin", 0);
  AddBin("1.bin", 1);
  Write("scans/0.bin", "seven b");
  const Read read = ReadAll();
  EXPECT_THAT(read.errors, testing::ElementsAre(HasSubstr("0.bin")));
  EXPECT_EQ(read.scans.size(), 1u);
}

TEST_F(FolderRecordingTest, GuessesTheSensor) {
  AddPcd("0.pcd", 15);
  EXPECT_EQ(ReadAll().sensor, "vlp16");
  AddPcd("0.pcd", 63);
  EXPECT_EQ(ReadAll().sensor, "hdl64");
  AddPcd("0.pcd", 0, /*has_ring=*/false);
  EXPECT_EQ(ReadAll().sensor, "");
  Write("simulation.json", R"({"sensor": "os1-64"})");
  EXPECT_EQ(ReadAll().sensor, "os1-64");
}

TEST_F(FolderRecordingTest, ABinWithRingsIsNoHdl64) {
  std::string bytes;
  for (int i = 0; i < 64; ++i) {
    for (const double value : {9 * std::cos(i), 9 * std::sin(i), -1.0, 7.0, i % 32 + 0.0}) {
      const auto number = static_cast<float>(value);
      bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
    }
  }
  Write("scans/a__LIDAR_TOP__1532402927647951.pcd.bin", bytes);
  const Read read = ReadAll();
  ASSERT_EQ(read.scans.size(), 1u) << read.status;
  EXPECT_EQ(read.sensor, "hdl32");
  EXPECT_EQ(read.scans[0].end_stamp_ns, 1532402927'647'951'000);
  EXPECT_THAT(read.assumptions, Contains(HasSubstr("x y z intensity ring")));
}

TEST_F(FolderRecordingTest, KittiMeansHdl64) {
  AddBin("0.bin", 0);
  EXPECT_EQ(ReadAll().sensor, "hdl64");
  EXPECT_THAT(ReadAll().assumptions, Contains(HasSubstr("hdl64")));
}

}  // namespace
}  // namespace isthmus::readers
