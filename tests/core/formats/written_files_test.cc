// Files for other programs, read by what the specifications say and by our own readers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "core/codec/payload_layout.h"
#include "core/formats/cloud_file.h"
#include "core/formats/kitti_poses.h"
#include "core/formats/las_writer.h"
#include "core/formats/mcap_writer.h"
#include "core/io/crc32.h"

namespace isthmus::formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

template <typename T>
T At(const std::string& bytes, size_t offset) {
  T value{};
  EXPECT_LE(offset + sizeof(T), bytes.size());
  if (offset + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

Eigen::Vector3d PlaceOf(const MapPoint& p) { return {double{p.x}, double{p.y}, double{p.z}}; }

const std::vector<MapPoint> kThree = {
    {1.5F, -2.25F, 0.125F, 10, 0}, {100, 200, -3, 255, 1}, {-7, 0, 42, 0, 1}};

std::vector<double> ColumnOf(const PointPayload& payload, const char* name) {
  const PointField* field = codec::FindField(payload, {name});
  return field == nullptr ? std::vector<double>() : codec::ReadColumn(payload, *field);
}

TEST(LasWriting, OurReaderReadsItBack) {
  LasWriter writer({.robots = {RobotId("alice"), RobotId("bob")}});
  const std::string points = writer.Points(kThree, PlaceOf);
  const auto las = ParseLas(writer.Header() + points);
  ASSERT_TRUE(las.ok()) << las.status();
  EXPECT_THAT(ColumnOf(*las, "x"), ElementsAre(1.5, 100, -7));
  EXPECT_THAT(ColumnOf(*las, "y"), ElementsAre(-2.25, 200, 0));
  EXPECT_THAT(ColumnOf(*las, "z"), ElementsAre(0.125, -3, 42));
  EXPECT_THAT(ColumnOf(*las, "intensity"), ElementsAre(2570, 65535, 0));
}

// Offsets of LAS 1.4 R15, table 3.
TEST(LasWriting, TheHeaderIsAsTheSpecificationSays) {
  LasWriter writer({.robots = {RobotId("alice")}, .created_ns = 1'709'251'200'000'000'000});
  const size_t size = writer.HeaderSize();
  const std::string points = writer.Points(kThree, PlaceOf);
  const std::string header = writer.Header();
  EXPECT_EQ(header.size(), size) << "it may be filled in at the end";
  EXPECT_EQ(header.substr(0, 8), std::string("LASF\0\0\x10\0", 8)) << "WKT, as format 6 asks";
  EXPECT_EQ(header[24], 1);
  EXPECT_EQ(header[25], 4);
  EXPECT_EQ(At<uint16_t>(header, 90), 61) << "day of the year of 2024-03-01";
  EXPECT_EQ(At<uint16_t>(header, 92), 2024);
  EXPECT_EQ(At<uint16_t>(header, 94), 375);
  EXPECT_EQ(At<uint32_t>(header, 96), header.size());
  EXPECT_EQ(At<uint32_t>(header, 100), 2u) << "variable length records";
  EXPECT_EQ(header[104], 6);
  EXPECT_EQ(At<uint16_t>(header, 105), 30);
  EXPECT_EQ(header.substr(107, 24), std::string(24, '\0')) << "legacy counts";
  EXPECT_EQ(At<double>(header, 131), 0.001);
  EXPECT_EQ(At<double>(header, 179), 100) << "max x";
  EXPECT_EQ(At<double>(header, 187), -7);
  EXPECT_EQ(At<double>(header, 195), 200);
  EXPECT_EQ(At<double>(header, 203), -2.25);
  EXPECT_EQ(At<double>(header, 211), 42);
  EXPECT_EQ(At<double>(header, 219), -3);
  EXPECT_EQ(At<uint64_t>(header, 227), 0u) << "waveforms";
  EXPECT_EQ(At<uint64_t>(header, 235), 0u);
  EXPECT_EQ(At<uint32_t>(header, 243), 0u) << "extended records";
  EXPECT_EQ(At<uint64_t>(header, 247), 3u);
  EXPECT_EQ(At<uint64_t>(header, 255), 3u) << "all are first returns";
  EXPECT_EQ(points.size(), 90u);
  // The first point, table 15.
  EXPECT_EQ(
      points.substr(0, 30),
      std::string("\xdc\x05\0\0\x36\xf7\xff\xff\x7d\0\0\0\x0a\x0a\x11\0\x01\0\0\0\x01\0", 22) +
          std::string(8, '\0'));
  EXPECT_EQ(At<uint16_t>(points, 30 + 20), 2) << "bob's";
}

TEST(LasWriting, RecordsNameRobotsAndSystem) {
  LasWriter writer({.robots = {RobotId("alice"), RobotId("bob")}, .wkt = "PROJCS[\"x\"]"});
  (void)writer.Points({{0, 0, 0, 0.5F, 0}}, PlaceOf);
  const std::string header = writer.Header();
  EXPECT_EQ(At<uint32_t>(header, 100), 3u);
  EXPECT_EQ(header.substr(375 + 2, 9), "LASF_Spec");
  EXPECT_EQ(At<uint16_t>(header, 375 + 18), 3);
  const size_t text = At<uint16_t>(header, 375 + 20);
  EXPECT_THAT(header.substr(375 + 54, text), HasSubstr("intensity is 65535 times"));
  EXPECT_THAT(header.substr(375 + 54, text), HasSubstr("point source 2: bob\n"));
  // Names of classes that are not the standard's: a number, and a name of 15 bytes.
  const size_t lookup = 375 + 54 + text;
  EXPECT_STREQ(header.data() + lookup + 2, "LASF_Spec");
  EXPECT_EQ(At<uint16_t>(header, lookup + 18), 0);
  EXPECT_EQ(At<uint16_t>(header, lookup + 20), 4096);
  EXPECT_EQ(header.substr(lookup + 54 + 16 * 64, 9), std::string("@ceiling\0", 9));
  EXPECT_EQ(header.substr(lookup + 54 + 16 * 2, 2), std::string("\x02\0", 2));
  const size_t wkt = lookup + 54 + 4096;
  EXPECT_STREQ(header.data() + wkt + 2, "LASF_Projection");
  EXPECT_EQ(At<uint16_t>(header, wkt + 18), 2112);
  EXPECT_EQ(At<uint16_t>(header, wkt + 20), 12) << "with its final zero";
  EXPECT_STREQ(header.data() + wkt + 54, "PROJCS[\"x\"]");
  EXPECT_EQ(wkt + 54 + 12, header.size());
}

TEST(LasWriting, ClassesAreTheStandardsWhereItHasThem) {
  std::vector<MapPoint> points(kPointClasses);
  for (size_t i = 0; i < points.size(); ++i) points[i].label = static_cast<PointClass>(i);
  LasWriter writer({});
  const std::string bytes = writer.Points(points, PlaceOf);
  std::vector<int> numbers;
  for (size_t i = 0; i < points.size(); ++i) numbers.push_back(bytes[30 * i + 16]);
  EXPECT_THAT(numbers, ElementsAre(1, 2, 64, 6, 65, 5, 66, 67, 68, 69));
}

TEST(LasWriting, LargeCoordinatesKeepTheirMillimetres) {
  LasWriter writer({.offset = {691'000, 5'335'000, 500}});
  const std::string points = writer.Points({{0, 0, 0, 0, 0}}, [](const MapPoint&) {
    return Eigen::Vector3d(691'608.123, 5'334'760.456, 520.789);
  });
  const auto las = ParseLas(writer.Header() + points);
  ASSERT_TRUE(las.ok());
  EXPECT_NEAR(ColumnOf(*las, "x")[0], 691'608.123, 1e-6);
  EXPECT_NEAR(ColumnOf(*las, "y")[0], 5'334'760.456, 1e-6);
  EXPECT_NEAR(ColumnOf(*las, "z")[0], 520.789, 1e-6);
}

TEST(LasWriting, WhatCannotBeStoredIsLeftOut) {
  LasWriter writer({});
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(writer.Points({{kNan, 0, 0, 0, 0}, {3e6F, 0, 0, 0, 0}}, PlaceOf).empty());
  EXPECT_EQ(writer.count(), 0u);
  EXPECT_EQ(ParseLas(writer.Header())->width, 0u);
  EXPECT_EQ(writer.Points({{0, 0, 0, kNan, 0}}, PlaceOf).size(), 30u);
}

TEST(KittiPoses, AreTheRowsOfAMatrix) {
  const Trajectory way = {{7, Pose()}, {8, Pose::FromXyzRpy(1, 2, 3, 0, 0, M_PI / 2)}};
  const std::string text = FormatKittiPoses(way);
  EXPECT_TRUE(text.starts_with("1 0 0 0 0 1 0 0 0 0 1 0\n")) << text;
  double v[12];
  const std::string second = text.substr(text.find('\n') + 1);
  ASSERT_EQ(std::sscanf(second.c_str(), "%lf%lf%lf%lf%lf%lf%lf%lf%lf%lf%lf%lf", v, v + 1, v + 2,
                        v + 3, v + 4, v + 5, v + 6, v + 7, v + 8, v + 9, v + 10, v + 11),
            12);
  EXPECT_NEAR(v[1], -1, 1e-12);
  EXPECT_NEAR(v[4], 1, 1e-12);
  EXPECT_EQ(v[3], 1);
  EXPECT_EQ(v[7], 2);
  EXPECT_EQ(v[11], 3);
}

// The records of a part of an MCAP file: operation, offset of the record, content.
struct McapRecord {
  uint8_t op = 0;
  size_t at = 0;
  std::string content;
};

std::vector<McapRecord> RecordsOf(const std::string& bytes, size_t from, size_t to) {
  std::vector<McapRecord> records;
  while (from < to) {
    const auto size = At<uint64_t>(bytes, from + 1);
    records.push_back({static_cast<uint8_t>(bytes[from]), from, bytes.substr(from + 9, size)});
    from += 9 + size;
  }
  EXPECT_EQ(from, to);
  return records;
}

std::string TwoTopics(size_t message_bytes, int messages) {
  std::string file;
  McapWriter writer([&file](const std::string& bytes) {
    file += bytes;
    return true;
  });
  const uint16_t schema = writer.AddSchema("foxglove.PoseInFrame", "protobuf", "schema bytes");
  const uint16_t a = writer.AddChannel(schema, "/a", "protobuf");
  const uint16_t b = writer.AddChannel(schema, "/b", "protobuf");
  for (int i = 0; i < messages; ++i) {
    writer.Write(i % 3 == 0 ? b : a, 1000 + i, std::string(message_bytes, static_cast<char>(i)));
  }
  EXPECT_TRUE(writer.Finish());
  return file;
}

TEST(McapWriting, ChecksumsAndOffsetsHold) {
  const std::string file = TwoTopics(300'000, 10);
  const std::string magic("\x89MCAP0\r\n", 8);
  ASSERT_TRUE(file.starts_with(magic) && file.ends_with(magic));
  const size_t footer = file.size() - 8 - 29;
  ASSERT_EQ(file[footer], 2);
  const auto summary = At<uint64_t>(file, footer + 9), offsets = At<uint64_t>(file, footer + 17);
  EXPECT_EQ(At<uint32_t>(file, footer + 25),
            io::Crc32(file.substr(summary, footer + 25 - summary)));
  const auto data = RecordsOf(file, 8, summary);
  EXPECT_EQ(data.front().op, 1);
  EXPECT_EQ(data.back().op, 15);
  EXPECT_EQ(At<uint32_t>(data.back().content, 0), io::Crc32(file.substr(0, data.back().at)));
  std::map<uint8_t, int> counts;
  for (const McapRecord& record : RecordsOf(file, summary, footer)) {
    ++counts[record.op];
    if (record.op == 14) {
      const auto start = At<uint64_t>(record.content, 1), length = At<uint64_t>(record.content, 9);
      for (const McapRecord& grouped : RecordsOf(file, start, start + length)) {
        EXPECT_EQ(grouped.op, static_cast<uint8_t>(record.content[0]));
      }
      EXPECT_GE(record.at, offsets);
    }
  }
  EXPECT_EQ(counts[3], 1);
  EXPECT_EQ(counts[4], 2);
  EXPECT_EQ(counts[8], 3) << "four messages of 300 kB make a chunk of a megabyte";
  EXPECT_EQ(counts[11], 1);
}

TEST(McapWriting, IndexesLeadToMessages) {
  const std::string file = TwoTopics(300'000, 10);
  const auto summary = At<uint64_t>(file, file.size() - 8 - 29 + 9);
  std::string records;  // The records of the chunk before.
  int messages = 0;
  for (const McapRecord& record : RecordsOf(file, 8, summary)) {
    if (record.op == 6) {
      EXPECT_EQ(At<uint32_t>(record.content, 28), 0u) << "no compression";
      records = record.content.substr(40);
      EXPECT_EQ(At<uint64_t>(record.content, 16), records.size());
      EXPECT_EQ(At<uint64_t>(record.content, 32), records.size());
      EXPECT_EQ(At<uint32_t>(record.content, 24), io::Crc32(records));
    }
    if (record.op != 7) continue;
    const auto channel = At<uint16_t>(record.content, 0);
    for (size_t at = 6; at < record.content.size(); at += 16, ++messages) {
      const auto time = At<uint64_t>(record.content, at);
      const auto offset = At<uint64_t>(record.content, at + 8);
      EXPECT_EQ(records[offset], 5);
      EXPECT_EQ(At<uint16_t>(records, offset + 9), channel);
      EXPECT_EQ(At<uint64_t>(records, offset + 15), time);
      EXPECT_EQ(static_cast<uint64_t>(records[offset + 31]), time - 1000) << "its first byte";
    }
  }
  EXPECT_EQ(messages, 10);
}

TEST(McapWriting, AFileWithoutMessagesIsWhole) {
  const std::string file = TwoTopics(0, 0);
  const size_t footer = file.size() - 8 - 29;
  for (const McapRecord& record : RecordsOf(file, At<uint64_t>(file, footer + 9), footer)) {
    if (record.op == 11) {
      EXPECT_EQ(record.content.substr(0, 8), std::string(8, '\0'));
    }
  }
}

TEST(McapWriting, ASinkThatFailsIsNotAskedAgain) {
  int calls = 0;
  McapWriter writer([&calls](const std::string&) { return ++calls < 1; });
  writer.Write(writer.AddChannel(writer.AddSchema("s", "", ""), "/a", ""), 1, "x");
  EXPECT_FALSE(writer.Finish());
  EXPECT_EQ(calls, 1);
}

}  // namespace
}  // namespace isthmus::formats
