#include "core/formats/pcd.h"

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <limits>

#include "core/codec/payload_builder.h"
#include "core/codec/payload_layout.h"
#include "core/codec/scan_decoder.h"
#include "core/formats/lzf.h"
#include "core/formats/map_writer.h"
#include "tests/core/codec/payloads.h"

namespace isthmus::formats {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using enum ScalarType;

constexpr PcdEncoding kEncodings[] = {PcdEncoding::kAscii, PcdEncoding::kBinary,
                                      PcdEncoding::kBinaryCompressed};

PointPayload EveryType() {
  PointPayload payload =
      codec::PayloadOf(30, 2)
          .Add<float>("x", kFloat32, [](uint32_t i) { return 0.1 * i; })
          .Add<int8_t>("a", kInt8, [](uint32_t i) { return i - 30; })
          .Add<double>("y", kFloat64, [](uint32_t i) { return i / 3.0; })
          .Add<uint16_t>("ring", kUint16, [](uint32_t i) { return i * 999; })
          .Add<int32_t>("b", kInt32, [](uint32_t i) { return -100000000 + 7 * int(i); })
          .Add<uint8_t>("p", kUint8, [](uint32_t i) { return i; })
          .Add<uint8_t>("q", kUint8, [](uint32_t i) { return 255 - i; })
          .Add<float>("z", kFloat32, [](uint32_t i) { return i == 7 ? std::nan("") : 1e-20 * i; })
          .Build();
  payload.fields[5].count = 2;  // p and q as one.
  payload.fields.erase(payload.fields.begin() + 6);
  return payload;
}

TEST(Pcd, RoundTripsEveryTypeInEveryEncoding) {
  const PointPayload raw = EveryType();
  const Pose viewpoint = Pose::FromXyzRpy(691'000.125, 5'334'002, 3, 0.1, 0.2, 0.3);
  for (const PcdEncoding encoding : kEncodings) {
    const auto bytes = FormatPcd(raw, encoding, viewpoint);
    ASSERT_TRUE(bytes.ok()) << bytes.status();
    const auto file = ParsePcd(*bytes);
    ASSERT_TRUE(file.ok()) << file.status();
    EXPECT_EQ(file->encoding, encoding);
    EXPECT_LT(Log(file->viewpoint.Inverse() * viewpoint).norm(), 1e-8);
    EXPECT_EQ(file->payload.width, 30u);
    EXPECT_EQ(file->payload.height, 2u);
    ASSERT_EQ(file->payload.fields.size(), raw.fields.size());
    for (size_t f = 0; f < raw.fields.size(); ++f) {
      EXPECT_EQ(file->payload.fields[f].name, raw.fields[f].name);
      EXPECT_EQ(file->payload.fields[f].type, raw.fields[f].type);
      EXPECT_EQ(file->payload.fields[f].count, raw.fields[f].count);
    }
    // Bit by bit but for the one NaN, of which text keeps no payload.
    PointPayload back = file->payload;
    const size_t nan_at = 7 * raw.stride + raw.fields.back().offset;
    EXPECT_TRUE(std::isnan(codec::ReadColumn(back, back.fields.back())[7]));
    back.data.replace(nan_at, 4, raw.data.substr(nan_at, 4));
    EXPECT_EQ(back.data, raw.data);
  }
}

TEST(Pcd, LeavesGapsOfRecordsOut) {
  PointPayload raw = codec::MakePayload(codec::RoomScan(10), true, true);
  raw.fields.erase(raw.fields.begin() + 3);
  for (const PcdEncoding encoding : kEncodings) {
    const auto file = ParsePcd(*FormatPcd(raw, encoding));
    ASSERT_TRUE(file.ok()) << file.status();
    EXPECT_EQ(file->payload.stride, raw.stride - 4);
    const auto before = codec::DecodeScan(raw, 1, 2),
               after = codec::DecodeScan(file->payload, 1, 2);
    ASSERT_TRUE(before.ok() && after.ok());
    EXPECT_EQ(after->points.back().z, before->points.back().z);
    EXPECT_EQ(after->points.back().ring, before->points.back().ring);
  }
}

TEST(Pcd, HoldsNoPoints) {
  for (const PcdEncoding encoding : kEncodings) {
    const auto file = ParsePcd(*FormatPcd(codec::MakePayload(Cloud{}), encoding));
    ASSERT_TRUE(file.ok()) << file.status();
    EXPECT_EQ(codec::PointCount(file->payload), 0u);
  }
}

TEST(Pcd, WritesAndReadsFiles) {
  const std::string path = ::testing::TempDir() + "isthmus_pcd_test.pcd";
  const PointPayload raw = codec::MakePayload(codec::RoomScan(10), true, true);
  ASSERT_TRUE(WritePcd(path, raw, PcdEncoding::kBinary).ok());
  EXPECT_EQ(ReadPcd(path)->payload.data, raw.data);
  std::remove(path.c_str());
  EXPECT_EQ(ReadPcd(path).status().code(), absl::StatusCode::kNotFound);
}

TEST(Pcd, ReadsPaddingWideIntegersAndOldHeaders) {
  std::string bytes =
      "# comment\r\nVERSION .5\r\nCOLUMNS x _ y z t\r\nSIZE 4 1 4 4 8\r\nTYPE F U F F U\r\n"
      "COUNT 1 2 1 1 1\r\nWIDTH 1\r\nHEIGHT 1\r\nDATA binary\r\n";
  const float xyz[] = {1, 2, 3};
  const uint64_t t = 1'700'000'000'000'000'000;
  bytes.append(reinterpret_cast<const char*>(&xyz[0]), 4);
  bytes.append("??");
  bytes.append(reinterpret_cast<const char*>(&xyz[1]), 8);
  bytes.append(reinterpret_cast<const char*>(&t), 8);
  const auto file = ParsePcd(bytes);
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_EQ(file->payload.fields.size(), 4u);
  EXPECT_EQ(codec::ReadColumn(file->payload, file->payload.fields[1])[0], 2);
  EXPECT_EQ(codec::ReadColumn(file->payload, file->payload.fields[3])[0], 1.7e18);
}

TEST(Pcd, WritesAMapPieceByPiece) {
  std::vector<MapPoint> points;
  for (int i = 0; i < 1000; ++i) {
    points.push_back({0.1f * i, -0.3f * i, 1e-3f * i, 0.5f, static_cast<uint32_t>(i % 3),
                      static_cast<PointClass>(i % kPointClasses)});
  }
  const std::vector<MapPoint> first(points.begin(), points.begin() + 300);
  const std::vector<MapPoint> second(points.begin() + 300, points.end());
  for (const PcdEncoding encoding : kEncodings) {
    std::string bytes = PcdMapHeader(points.size(), encoding, {RobotId("alice"), RobotId("b\nob")});
    if (encoding == PcdEncoding::kBinaryCompressed) {
      bytes += *PcdMapCompressed(points);
    } else {
      bytes += PcdMapChunk(first, encoding) + PcdMapChunk(second, encoding);
    }
    EXPECT_THAT(bytes, HasSubstr("# robot 0 alice\n# robot 1 b ob\n"));
    const auto file = ParsePcd(bytes);
    ASSERT_TRUE(file.ok()) << file.status();
    std::string records(points.size() * kMapRecordBytes, '\0');
    CopyMapRecords(points, records.data());
    EXPECT_EQ(file->payload.data, records);
    EXPECT_EQ(file->payload.fields[4].name, "robot");
    EXPECT_EQ(file->payload.fields[4].type, kUint32);
    EXPECT_EQ(file->payload.fields[5].name, "label");
    EXPECT_EQ(file->payload.fields[5].type, kUint32);
  }
}

TEST(Ply, IsHeaderAndRecords) {
  const std::vector<MapPoint> points = {{1, 2, 3, 4, 5, PointClass::kWall}, {6, 7, 8, 9, 10}};
  const std::string header = PlyMapHeader(2, {RobotId("alice")});
  EXPECT_EQ(header,
            "ply\nformat binary_little_endian 1.0\ncomment robot 0 alice\nelement vertex 2\n"
            "property float x\nproperty float y\nproperty float z\nproperty float intensity\n"
            "property uint robot\nproperty uint label\nend_header\n");
  const std::string chunk = PlyMapChunk(points);
  ASSERT_EQ(chunk.size(), 48u);
  float z = 0;
  std::memcpy(&z, &chunk[32], 4);
  EXPECT_EQ(z, 8);
  EXPECT_EQ(chunk[16], 5);
  EXPECT_EQ(chunk[20], 3);
}

// A good header with one line replaced, and ascii data for two points.
std::string Text(const std::string& key = "", const std::string& line = "",
                 const std::string& data = "1 2 3\n4 5 6\n") {
  const std::pair<const char*, const char*> lines[] = {
      {"VERSION", "VERSION 0.7"}, {"FIELDS", "FIELDS x y z"},
      {"SIZE", "SIZE 4 4 4"},     {"TYPE", "TYPE F F F"},
      {"COUNT", "COUNT 1 1 1"},   {"WIDTH", "WIDTH 2"},
      {"HEIGHT", "HEIGHT 1"},     {"VIEWPOINT", "VIEWPOINT 0 0 0 1 0 0 0"},
      {"POINTS", "POINTS 2"},     {"DATA", "DATA ascii"}};
  std::string text;
  for (const auto& [name, good] : lines) {
    const std::string& chosen = name == key ? line : good;
    if (!chosen.empty()) text += chosen + "\n";
  }
  return text + data;
}

TEST(Pcd, RefusesHeadersThatLie) {
  ASSERT_TRUE(ParsePcd(Text()).ok()) << ParsePcd(Text()).status();
  const std::pair<const char*, const char*> bad[] = {{"FIELDS", ""},
                                                     {"FIELDS", "FIELDS x y"},
                                                     {"FIELDS", "FIELDS"},
                                                     {"SIZE", "SIZE 4 4 3"},
                                                     {"SIZE", "SIZE 0 0 0"},
                                                     {"SIZE", "SIZE 4 4 -4"},
                                                     {"SIZE", "SIZE 4 4 4 4"},
                                                     {"TYPE", "TYPE F F Q"},
                                                     {"TYPE", "TYPE F F FF"},
                                                     {"COUNT", "COUNT 1 1 0"},
                                                     {"COUNT", "COUNT 1 1 4294967295"},
                                                     {"WIDTH", "WIDTH -2"},
                                                     {"WIDTH", "WIDTH 3"},
                                                     {"WIDTH", "WIDTH 2 2"},
                                                     {"WIDTH", "WIDTH 99999999999"},
                                                     {"HEIGHT", "HEIGHT 2"},
                                                     {"HEIGHT", "HEIGHT\nHEIGHT 1"},
                                                     {"POINTS", "POINTS 3"},
                                                     {"DATA", "DATA"},
                                                     {"DATA", ""},
                                                     {"DATA", "DATA binary_zip"},
                                                     {"DATA", "NONSENSE 1"},
                                                     {"POINTS", "WIDTH 2"}};
  for (const auto& [key, line] : bad) {
    const auto status = ParsePcd(Text(key, line)).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << key << ": " << line;
    EXPECT_THAT(std::string(status.message()), StartsWith("PCD header")) << key << ": " << line;
  }
  EXPECT_THAT(std::string(ParsePcd("FIELDS x\nHEIGHT 1\nDATA ascii\n").status().message()),
              HasSubstr("neither WIDTH nor POINTS"));
  EXPECT_FALSE(ParsePcd("").ok());
  EXPECT_FALSE(ParsePcd(std::string(1000, '\0')).ok());
}

TEST(Pcd, RefusesRowsThatLie) {
  for (const char* data : {"", "1 2 3\n", "1 2 3\n4 5\n", "1 2 3\n4 5 6 7\n", "1 2 3\n4 5 x\n",
                           "1 2 3 4 5 6\n", "1 2 3\n4 5 6e999\n"}) {
    const auto status = ParsePcd(Text("", "", data)).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << data;
    EXPECT_THAT(std::string(status.message()), StartsWith("PCD data")) << data;
  }
  const std::string bytes = Text("TYPE", "TYPE F F U", "1 2 3\n4 5 -6\n");  // z is needed.
  EXPECT_THAT(std::string(ParsePcd(bytes).status().message()), HasSubstr("row 2: '-6'"));
}

std::vector<double> Column(const absl::StatusOr<PcdFile>& file, const char* name) {
  EXPECT_TRUE(file.ok()) << file.status();
  if (!file.ok()) return {};
  EXPECT_TRUE(codec::CheckRawLayout(file->payload).ok());
  const PointField* field = codec::FindField(file->payload, {name});
  EXPECT_NE(field, nullptr) << name;
  return field == nullptr ? std::vector<double>() : codec::ReadColumn(file->payload, *field);
}

// Two points, z = 3 and 6, of headers that leave out or spoil what others tell or nothing needs.
TEST(Pcd, DoesWithoutWhatIsNotNeeded) {
  const std::pair<const char*, const char*> odd[] = {{"WIDTH", ""},
                                                     {"HEIGHT", ""},
                                                     {"WIDTH", "WIDTH 0"},
                                                     {"HEIGHT", "HEIGHT 0"},
                                                     {"COUNT", ""},
                                                     {"SIZE", ""},
                                                     {"TYPE", ""},
                                                     {"VERSION", "VERSION ?"},
                                                     {"VERSION", "LABELS none"},
                                                     {"VIEWPOINT", "VIEWPOINT 0 0 0 0 0 0 0"},
                                                     {"VIEWPOINT", "VIEWPOINT 1 2 3"},
                                                     {"VIEWPOINT", "VIEWPOINT 0 0 0 nan 0 0 0"}};
  for (const auto& [key, line] : odd) {
    const auto file = ParsePcd(Text(key, line));
    EXPECT_THAT(Column(file, "z"), ElementsAre(3, 6)) << key << ": " << line;
    EXPECT_TRUE(file.ok() && file->viewpoint.Matrix().isIdentity()) << key << ": " << line;
    EXPECT_TRUE(file.ok() && file->payload.width == 2 && file->payload.height == 1) << line;
  }
  const auto oldest = ParsePcd("COLUMNS x y z\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n7 8 9\n");
  EXPECT_THAT(Column(oldest, "z"), ElementsAre(3, 6));
}

std::string WithField(const std::string& type, const std::string& rows) {
  return "FIELDS x y z other\nSIZE 4 4 4 " + type.substr(1) + "\nTYPE F F F " + type[0] +
         "\nWIDTH 2\nHEIGHT 1\nDATA ascii\n" + rows;
}

TEST(Pcd, ReadsValuesThatTheirFieldHoldsHoweverTheyAreWritten) {
  const struct {
    const char *type, *first, *second;
    double values[2];
  } cases[] = {{"U2", "4.0", "5.", {4, 5}},
               {"U4", "4.2108e+06", "4e0", {4210800, 4}},
               {"F4", "1e-50", "7", {0, 7}},
               {"F8", "1e-400", "+7", {0, 7}},
               {"U4", "-1", "4294967295", {0, 4294967295}},
               {"I1", "200", "x", {0, 0}}};
  for (const auto& c : cases) {
    const auto file =
        ParsePcd(WithField(c.type, absl::StrCat("1 2 3 ", c.first, "\n1 2 4 ", c.second, "\n")));
    EXPECT_THAT(Column(file, "z"), ElementsAre(3, 4)) << c.first;
    EXPECT_THAT(Column(file, "other"), ElementsAreArray(c.values)) << c.first;
  }
  const auto nan = Column(ParsePcd(WithField("F4", "1 2 3 1e99\n1 2 4 -\n")), "other");
  ASSERT_EQ(nan.size(), 2u);
  EXPECT_TRUE(std::isnan(nan[0]) && std::isnan(nan[1]));
}

// A field of a type that does not exist is passed over: its size is known.
TEST(Pcd, PassesOverFieldsOfNoValuesAndOfUnknownTypes) {
  const std::string head =
      "FIELDS _ x y half z _ none\nSIZE 1 4 4 2 4 1 8\nTYPE U F F F F U Q\n"
      "COUNT 0 1 1 2 1 3 0\nWIDTH 2\nHEIGHT 1\nDATA ";
  std::string records, columns;
  for (float i : {0.0F, 10.0F}) {
    const float xy[] = {i + 1, i + 2}, z = i + 3;
    records.append(reinterpret_cast<const char*>(xy), 8).append("hhHH");
    records.append(reinterpret_cast<const char*>(&z), 4).append("___");
  }
  const std::string page(4000, '\0');  // Some versions of PCL leave such a page behind the data.
  const auto binary = ParsePcd(head + "binary\n" + records + page);
  const auto ascii = ParsePcd(head + "ascii\n1 2 h H 3 _ _ _\n11 12 h H 13 _ _ _\n");
  for (const int part : {0, 4, 8, 12}) {
    for (const int record : {0, 19}) columns += records.substr(record + part, 4);
  }
  const auto packed = ParsePcd(head + "binary_compressed\n" + *LzfBlock(columns) + page);
  for (const auto* file : {&binary, &ascii, &packed}) {
    EXPECT_THAT(Column(*file, "x"), ElementsAre(1, 11));
    EXPECT_THAT(Column(*file, "z"), ElementsAre(3, 13));
    EXPECT_EQ((*file)->payload.fields.size(), 3u);
  }
  EXPECT_EQ(ascii->payload.stride, 12u);  // Words that nothing needs take no room.
  EXPECT_THAT(
      std::string(
          ParsePcd("FIELDS _\nSIZE 1\nTYPE U\nWIDTH 1\nDATA ascii\n1\n").status().message()),
      HasSubstr("nothing but padding"));
}

// Headers that announce up to 2^64 points over a few bytes must not lead to their allocation.
TEST(Pcd, RefusesGiantsWithoutAllocatingThem) {
  for (const char* data : {"DATA ascii", "DATA binary", "DATA binary_compressed"}) {
    for (const char* size : {"WIDTH 4000000000\nHEIGHT 4000000000", "WIDTH 300000000\nHEIGHT 1",
                             "WIDTH 2147483648\nHEIGHT 2147483648"}) {
      const std::string bytes = std::string("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n") + size +
                                "\n" + data + "\n" + std::string(64, '\x01');
      EXPECT_EQ(ParsePcd(bytes).status().code(), absl::StatusCode::kInvalidArgument) << bytes;
    }
  }
}

// 4 bytes packed, 65,000 beside them that are in no compressed file.
TEST(Pcd, PaddingOfPackedPointsTakesNoMemory) {
  const size_t points = 1000;
  const std::string block = *LzfBlock(std::string(points * 4, '\0'));
  const auto file = ParsePcd(
      "FIELDS x _\nSIZE 4 1\nTYPE F U\nCOUNT 1 65000\nWIDTH 1000\nHEIGHT 1\n"
      "DATA binary_compressed\n" +
      block);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(file->payload.data.size(), points * 4);
  EXPECT_TRUE(codec::CheckRawLayout(file->payload).ok());
}

// Truncation is always noticed; a flipped byte may change a number, but nothing may crash.
TEST(Pcd, SurvivesDamage) {
  const PointPayload raw = codec::MakePayload(codec::RoomScan(4), true, true);
  for (const PcdEncoding encoding : kEncodings) {
    const std::string good = *FormatPcd(raw, encoding);
    const size_t last = good.size() - (encoding == PcdEncoding::kAscii ? 12 : 1);
    for (size_t size = 0; size < last; ++size) {
      ASSERT_FALSE(ParsePcd(good.substr(0, size)).ok()) << size;
    }
    for (size_t i = 0; i < good.size(); ++i) {
      std::string bad = good;
      bad[i] = static_cast<char>(bad[i] ^ 0x55);
      if (const auto file = ParsePcd(bad); file.ok()) {
        EXPECT_TRUE(codec::CheckRawLayout(file->payload).ok()) << i;
      }
    }
  }
}

TEST(Pcd, RefusesNamesThatBreakTheHeader) {
  PointPayload raw = codec::MakePayload(codec::RoomScan(1), false, false);
  for (const char* name : {"", "_", "two words", "new\nline"}) {
    raw.fields[3].name = name;
    EXPECT_EQ(FormatPcd(raw, PcdEncoding::kAscii).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace isthmus::formats
