#include <absl/strings/str_replace.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "client/readers/packets/packet_decoder.h"
#include "core/codec/payload_layout.h"
#include "core/codec/scan_decoder.h"
#include "tests/client/readers/packets/packet_writer.h"

namespace isthmus::readers {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using testing::OusterMetadata;
using testing::OusterPacket;
using testing::OusterSource;

std::vector<double> OusterColumn(const RecordedScan& scan, const char* name) {
  EXPECT_TRUE(codec::CheckLayout(scan.payload).ok());
  const PointField* field = codec::FindField(scan.payload, {name});
  return field == nullptr ? std::vector<double>() : codec::ReadColumn(scan.payload, *field);
}

std::unique_ptr<PacketDecoder> OusterOf(const OusterSource& source, bool nested = false) {
  auto decoder = MakeOusterDecoder(OusterMetadata(source, nested));
  EXPECT_TRUE(decoder.ok()) << decoder.status();
  return *std::move(decoder);
}

void AddFrame(PacketDecoder& decoder, const OusterSource& source,
              std::vector<RecordedScan>& scans) {
  for (int column = 0; column < source.columns; column += 16) {
    const int64_t last = static_cast<int64_t>(
        source.start_ns + source.column_ns * static_cast<uint64_t>(column + 15));
    const absl::Status status = decoder.Add(OusterPacket(source, column), last, &scans);
    EXPECT_TRUE(status.ok()) << status;
  }
}

TEST(OusterDecoder, ReadsEveryProfileAndLayoutOfMetadata) {
  for (const char* profile :
       {"LEGACY", "RNG19_RFL8_SIG16_NIR16", "RNG19_RFL8_SIG16_NIR16_DUAL", "RNG15_RFL8_NIR8"}) {
    for (const bool nested : {false, true}) {
      OusterSource source;
      source.profile = profile;
      source.start_ns = 1'700'000'000'000'000'000;
      const auto decoder = OusterOf(source, nested);
      EXPECT_EQ(decoder->sensor(), "os1-16");
      std::vector<RecordedScan> scans;
      AddFrame(*decoder, source, scans);
      decoder->Flush(&scans);
      ASSERT_EQ(scans.size(), 1u);
      EXPECT_EQ(scans[0].payload.width, 64u * 16);  // Both returns are the same here.
      EXPECT_EQ(scans[0].end_stamp_ns, 1'700'000'000'000'000'000 + 63'000'000);
      EXPECT_THAT(OusterColumn(scans[0], "range"), Each(8000));
      EXPECT_EQ(OusterColumn(scans[0], "reflectivity")[18], 3);
      const bool low = source.profile == "RNG15_RFL8_NIR8";
      EXPECT_EQ(OusterColumn(scans[0], "intensity")[18], low ? 3 : 1002);
      EXPECT_EQ(OusterColumn(scans[0], "ring")[18], 2);
      EXPECT_NEAR(OusterColumn(scans[0], "time")[18], -0.062, 1e-8);
    }
  }
}

// As the manual writes it, with its own names.
std::array<double, 3> ByTheManual(const OusterSource& source, int column, int row) {
  const double n = 15.8, r = source.range(column, row, 0), degree = std::numbers::pi / 180;
  const double encoder = 2 * std::numbers::pi * (1 - static_cast<double>(column) / source.columns);
  const double azimuth = -2 * std::numbers::pi * ((row % 2 == 0 ? 4.25 : -1.42) / 360);
  const double altitude = (20.0 - 40.0 * row / (source.rows - 1)) * degree;
  const double x =
      (r - n) * std::cos(encoder + azimuth) * std::cos(altitude) + n * std::cos(encoder);
  const double y =
      (r - n) * std::sin(encoder + azimuth) * std::cos(altitude) + n * std::sin(encoder);
  const double z = (r - n) * std::sin(altitude);
  return {-x / 1000, -y / 1000, (z + 36.18) / 1000};
}

TEST(OusterDecoder, PutsPointsWhereTheManualDoes) {
  OusterSource source;
  source.range = [](int column, int row, int) {
    return static_cast<uint32_t>(2000 + 100 * row + 8 * column);
  };
  for (const bool nested : {false, true}) {
    const auto decoder = OusterOf(source, nested);
    std::vector<RecordedScan> scans;
    AddFrame(*decoder, source, scans);
    decoder->Flush(&scans);
    const std::vector<double> x = OusterColumn(scans.at(0), "x"), y = OusterColumn(scans[0], "y"),
                              z = OusterColumn(scans[0], "z");
    size_t i = 0;
    for (int column = 0; column < 64; ++column) {
      for (int row = 0; row < 16; ++row, ++i) {  // Column by column, from the uppermost beam down.
        const std::array<double, 3> expected = ByTheManual(source, column, row);
        ASSERT_NEAR(x[i], expected[0], 3e-6);
        ASSERT_NEAR(y[i], expected[1], 3e-6);
        ASSERT_NEAR(z[i], expected[2], 3e-6);
      }
    }
  }
}

TEST(OusterDecoder, KeepsTwoReturnsAndDropsTheSame) {
  OusterSource source;
  source.profile = "RNG19_RFL8_SIG16_NIR16_DUAL";
  source.range = [](int, int row, int which) -> uint32_t {
    if (row == 0) return which == 0 ? 5000 : 9000;
    if (row == 1) return which == 0 ? 0 : 7000;
    return row == 2 ? 4000 : 0;
  };
  const auto decoder = OusterOf(source);
  std::vector<RecordedScan> scans;
  AddFrame(*decoder, source, scans);
  decoder->Flush(&scans);
  ASSERT_EQ(scans.at(0).payload.width, 64u * 4);
  const std::vector<double> range = OusterColumn(scans[0], "range");
  EXPECT_EQ(std::vector(range.begin(), range.begin() + 4),
            (std::vector<double>{5000, 9000, 7000, 4000}));
  EXPECT_THAT(decoder->Assumptions(), Contains(HasSubstr("both returns become points")));
}

TEST(OusterDecoder, CutsByFrameAlsoWhereItsNumberStartsAgain) {
  for (const char* profile : {"LEGACY", "RNG19_RFL8_SIG16_NIR16"}) {
    OusterSource source;
    source.profile = profile;
    const auto decoder = OusterOf(source);
    std::vector<RecordedScan> scans;
    for (const uint16_t frame : {65534, 65535, 0, 1}) {
      source.frame = frame;
      AddFrame(*decoder, source, scans);
      source.start_ns += 100'000'000;
    }
    EXPECT_EQ(scans.size(), 3u);
    for (const RecordedScan& scan : scans) EXPECT_EQ(scan.payload.width, 64u * 16);
  }
}

TEST(OusterDecoder, LeavesOutWhatIsMissingInvalidLateOrTwice) {
  OusterSource source;
  source.valid = [](int column) { return column % 4 != 0; };
  source.range = [](int, int row, int) { return row == 3 ? 0u : 8000u; };
  const auto decoder = OusterOf(source);
  std::vector<RecordedScan> scans;
  for (const int column : {0, 48, 16, 16}) {  // One is lost, one comes late, one twice.
    ASSERT_TRUE(decoder->Add(OusterPacket(source, column), 0, &scans).ok());
  }
  source.frame = 2;
  ASSERT_TRUE(decoder->Add(OusterPacket(source, 0), 0, &scans).ok());
  source.frame = 1;  // The frame before.
  ASSERT_TRUE(decoder->Add(OusterPacket(source, 32), 0, &scans).ok());
  ASSERT_EQ(scans.size(), 1u);
  EXPECT_EQ(scans[0].payload.width, 3u * 12 * 15);
  decoder->Flush(&scans);
  EXPECT_EQ(scans.at(1).payload.width, 12u * 15);
}

TEST(OusterDecoder, PutsABootClockOnThatOfArrival) {
  OusterSource source;
  source.start_ns = 12'000'000'000;
  const auto decoder = OusterOf(source, true);
  std::vector<RecordedScan> scans;
  const int64_t boot = 1'700'000'000'000'000'000;
  for (int column = 0; column < 64; column += 16) {
    const int64_t last = static_cast<int64_t>(source.start_ns) + 1'000'000 * (column + 15);
    const int64_t delay = column == 16 ? 200'000 : 5'000'000;
    ASSERT_TRUE(decoder->Add(OusterPacket(source, column), boot + last + delay, &scans).ok());
  }
  decoder->Flush(&scans);
  EXPECT_EQ(scans.at(0).end_stamp_ns, boot + 12'063'000'000 + 200'000);
  EXPECT_THAT(decoder->Assumptions(), Contains(HasSubstr("not synchronised")));
}

TEST(OusterDecoder, ScansAreUnderstoodByTheServer) {
  OusterSource source;
  source.column_ns = 1'500'000;
  source.start_ns = 1'700'000'000'000'000'000;
  const auto decoder = OusterOf(source);
  std::vector<RecordedScan> scans;
  AddFrame(*decoder, source, scans);
  decoder->Flush(&scans);
  codec::ScanDecoder server;
  const auto scan = server.Decode(scans.at(0).payload, 0, scans[0].end_stamp_ns);
  ASSERT_TRUE(scan.ok()) << scan.status();
  EXPECT_TRUE(scan->has_time && scan->has_ring);
  // Rings of the server count from the lowest up.
  EXPECT_EQ(scan->points[0].ring, 15);
  EXPECT_GT(scan->points[0].z, scan->points[15].z);
  EXPECT_NEAR(scan->points[0].time, -63 * 0.0015, 1e-6);
}

TEST(OusterDecoder, RefusesPacketsOfAnotherSensor) {
  OusterSource source;
  const auto decoder = OusterOf(source);
  std::vector<RecordedScan> scans;
  const std::string good = OusterPacket(source, 0);
  std::string other_type = good;
  other_type[0] = 2;
  for (const std::string& bad : {std::string(), good.substr(1), good + "x", other_type}) {
    const absl::Status status = decoder->Add(bad, 0, &scans);
    EXPECT_TRUE(absl::IsInvalidArgument(status));
    EXPECT_THAT(std::string(status.message()), HasSubstr("metadata"));
  }
  // Columns beyond the frame and times beyond all years are no points.
  std::string lies = good;
  lies[32 + 8] = lies[32 + 9] = '\xFF';
  lies.replace(32 + 12 + 16 * 12, 8, 8, '\xFF');
  ASSERT_TRUE(decoder->Add(lies, 0, &scans).ok());
  decoder->Flush(&scans);
  EXPECT_EQ(scans.at(0).payload.width, 14u * 16);
}

TEST(OusterDecoder, SaysWhatIsWrongWithMetadata) {
  const std::string good = OusterMetadata({}, false);
  const auto with = [&](const char* from, const char* to) {
    return absl::StrReplaceAll(good, {{from, to}});
  };
  for (const auto& [json, words] :
       {std::pair(std::string(), "no JSON object"), std::pair(std::string("[1]"), "no JSON object"),
        std::pair(good.substr(0, 100), "no JSON object"),
        std::pair(std::string("{}"), "columns_per_frame"),
        std::pair(with("\"columns_per_frame\": 64", "\"columns_per_frame\": -1"), "not from 1"),
        std::pair(with("\"columns_per_frame\": 64", "\"columns_per_frame\": 1e9"), "has no"),
        std::pair(with("\"columns_per_frame\": 64", "\"columns_per_frame\": 99999999999"),
                  "not from 1"),
        std::pair(with("\"pixels_per_column\": 16", "\"pixels_per_column\": 17"), "17 numbers"),
        std::pair(with("\"beam_azimuth_angles\": [4.25", "\"beam_azimuth_angles\": [\"a\""),
                  "16 numbers"),
        std::pair(with("RNG19_RFL8_SIG16_NIR16", "FUSA_RNG15_RFL8_NIR8_DUAL"),
                  "FUSA_RNG15_RFL8_NIR8_DUAL, which is not read"),
        std::pair(with("lidar_origin_to_beam_origin_mm", "x"), "lidar_origin_to_beam_origin_mm"),
        std::pair(with("36.18", "1e30"), "lidar_to_sensor_transform")}) {
    const auto decoder = MakeOusterDecoder(json);
    EXPECT_TRUE(absl::IsInvalidArgument(decoder.status())) << json;
    EXPECT_THAT(std::string(decoder.status().message()), HasSubstr(words)) << json;
  }
}

TEST(OusterDecoder, RefusesTheMetadataOfAnotherUnit) {
  const auto add = [](const OusterSource& source, bool nested) {
    std::vector<RecordedScan> scans;
    return (*MakeOusterDecoder(testing::OusterMetadata(source, nested)))
        ->Add(testing::OusterPacket(source, 0), 0, &scans);
  };
  OusterSource source;
  source.serial = source.told_serial = 122150000150;
  source.start = source.told_start = 0x1234567;
  source.start &= 0xFFFFFF;
  for (const bool nested : {false, true}) {
    EXPECT_TRUE(add(source, nested).ok());
    OusterSource other = source;
    other.told_serial = 992101000280;
    EXPECT_TRUE(absl::IsFailedPrecondition(add(other, nested)));
    EXPECT_THAT(std::string(add(other, nested).message()), HasSubstr("122150000150"));
    OusterSource again = source;
    again.told_start = 77;  // The same unit, started again.
    EXPECT_TRUE(add(again, nested).ok());
    again.told_serial = 0;  // Perhaps another unit.
    EXPECT_TRUE(absl::IsFailedPrecondition(add(again, nested)));
  }
  source.told_serial = 992101000280;
  source.profile = "LEGACY";  // Does not say.
  EXPECT_TRUE(add(source, false).ok());
}

}  // namespace
}  // namespace isthmus::readers
