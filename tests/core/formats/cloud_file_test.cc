#include "core/formats/cloud_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/codec/payload_layout.h"
#include "core/formats/map_writer.h"

namespace isthmus::formats {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<double> Column(const PointPayload& payload, const char* name) {
  EXPECT_TRUE(codec::CheckRawLayout(payload).ok());
  const PointField* field = codec::FindField(payload, {name});
  EXPECT_NE(field, nullptr) << name;
  return field == nullptr ? std::vector<double>() : codec::ReadColumn(payload, *field);
}

template <typename T>
void Put(std::string& bytes, size_t at, T value) {
  if (bytes.size() < at + sizeof(T)) bytes.resize(at + sizeof(T));
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

const char kPlyHeader[] =
    "ply\nformat FORMAT 1.0\ncomment by hand\nelement vertex 2\nproperty float x\n"
    "property double y\nproperty float32 z\nproperty uchar scalar_Intensity\n"
    "element face 1\nproperty list uchar int vertex_index\nend_header\n";

std::string PlyHeaderOf(const std::string& format) {
  std::string header = kPlyHeader;
  header.replace(header.find("FORMAT"), 6, format);
  return header;
}

void ExpectPlyPoints(const absl::StatusOr<PointPayload>& ply) {
  ASSERT_TRUE(ply.ok()) << ply.status();
  EXPECT_EQ(ply->width, 2);
  EXPECT_THAT(Column(*ply, "x"), ElementsAre(1.5, -4));
  EXPECT_THAT(Column(*ply, "y"), ElementsAre(2.25, 5));
  EXPECT_THAT(Column(*ply, "z"), ElementsAre(3, 6));
  EXPECT_THAT(Column(*ply, "intensity"), ElementsAre(7, 255));
}

TEST(PlyReader, ReadsAsciiAndSkipsFaces) {
  ExpectPlyPoints(ParsePly(PlyHeaderOf("ascii") + "1.5 2.25 3 7\n-4 5 6.0 255\n3 0 1 1\n"));
}

TEST(PlyReader, ReadsEitherByteOrder) {
  for (const bool is_big : {false, true}) {
    std::string bytes = PlyHeaderOf(is_big ? "binary_big_endian" : "binary_little_endian");
    const auto add = [&](auto value) {
      char raw[sizeof(value)];
      std::memcpy(raw, &value, sizeof(value));
      if (is_big) std::reverse(raw, raw + sizeof(value));
      bytes.append(raw, sizeof(value));
    };
    add(1.5F), add(2.25), add(3.0F), add(uint8_t{7});
    add(-4.0F), add(5.0), add(6.0F), add(uint8_t{255});
    ExpectPlyPoints(ParsePly(bytes + "faces"));
    EXPECT_THAT(ParsePly(bytes.substr(0, bytes.size() - 1)).status().message(),
                HasSubstr("truncated"));
  }
}

TEST(PlyReader, ReadsTheMapsThatAreWritten) {
  std::string bytes = PlyMapHeader(1, {RobotId("alice")});
  MapPoint point;
  point.x = 1;
  point.z = 3;
  bytes += PlyMapChunk({point});
  const auto ply = ParsePly(bytes);
  ASSERT_TRUE(ply.ok()) << ply.status();
  EXPECT_THAT(Column(*ply, "z"), ElementsAre(3));
}

TEST(PlyReader, RefusesWhatItCannotRead) {
  const auto message = [](const std::string& bytes) {
    return std::string(ParsePly(bytes).status().message());
  };
  EXPECT_THAT(message("solid"), HasSubstr("end_header"));
  EXPECT_THAT(message("solid\n"), HasSubstr("begin with 'ply'"));
  EXPECT_THAT(message("ply\nformat ascii 1.0\nend_header\n"), HasSubstr("no element 'vertex'"));
  EXPECT_THAT(message(PlyHeaderOf("ascii") + "1 2 3 4\n"), HasSubstr("truncated"));
  EXPECT_THAT(message(PlyHeaderOf("ascii") + "1 2 3 4\n5 6 seven 8 and more\n"),
              HasSubstr("'seven' is no number for 'z' (vertex 2)"));
  EXPECT_THAT(message(PlyHeaderOf("ascii") + "1 2 3 4 9\n5 6 7 8 9\n"),
              HasSubstr("more values in the row than the header announces (vertex 1)"));
  EXPECT_THAT(message(PlyHeaderOf("ascii") + "1 2 3\n4 5 6 7\n8 9 10\n"),
              HasSubstr("more values in the row"));
  const std::string unknown = "element vertex 2\nproperty half x\nend_header\n";
  EXPECT_THAT(message("ply\nformat binary_little_endian 1.0\n" + unknown + "1234"),
              HasSubstr("'x' has a type that is not known"));
  EXPECT_THAT(message("ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\n"
                      "property float x\nend_header\n"),
              HasSubstr("too many"));
}

// Elements before the points, lists and 64-bit integers, in every encoding.
std::string PlyOfEverything(const std::string& format, bool is_big) {
  std::string bytes = "ply\nformat " + format +
                      " 1.0\nelement empty 18446744073709551615\nelement camera 1\n"
                      "property float vx\nproperty list uchar short face\nelement vertex 2\n"
                      "property list uchar int views\nproperty float x\nproperty uint64 t\n"
                      "property float y\nproperty list int double w\nproperty float z\n"
                      "property int64 n\nelement vertex 1\nproperty float x\nend_header\n";
  const bool is_ascii = format == "ascii";
  const auto add = [&](auto value) {
    if (is_ascii) {
      bytes += std::to_string(value) + " ";
      return;
    }
    char raw[sizeof(value)];
    std::memcpy(raw, &value, sizeof(value));
    if (is_big) std::reverse(raw, raw + sizeof(value));
    bytes.append(raw, sizeof(value));
  };
  const auto end_row = [&] {
    if (is_ascii) bytes += "\n";
  };
  add(9.0F), add(uint8_t{3}), add(int16_t{7}), add(int16_t{8}), add(int16_t{9}), end_row();
  for (const int i : {0, 1}) {
    add(static_cast<uint8_t>(2 * i));
    for (int k = 0; k < 2 * i; ++k) add(int32_t{77});
    add(1.0F + static_cast<float>(i)), add(uint64_t{1} << 62), add(3.0F);
    add(int32_t{1}), add(0.5);
    add(4.0F), add(int64_t{-5}), end_row();
  }
  return bytes;
}

TEST(PlyReader, PassesOverWhatIsNotNeeded) {
  for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const std::string bytes = PlyOfEverything(format, format == "binary_big_endian");
    const auto ply = ParsePly(bytes);
    ASSERT_TRUE(ply.ok()) << ply.status();
    EXPECT_THAT(Column(*ply, "x"), ElementsAre(1, 2)) << format;
    EXPECT_THAT(Column(*ply, "y"), ElementsAre(3, 3)) << format;
    EXPECT_THAT(Column(*ply, "z"), ElementsAre(4, 4)) << format;
    EXPECT_THAT(Column(*ply, "t"), ElementsAre(0x1p62, 0x1p62)) << format;
    EXPECT_THAT(Column(*ply, "n"), ElementsAre(-5, -5)) << format;
    EXPECT_EQ(ply->fields.size(), 5u);
    const size_t data = bytes.find("end_header");
    for (size_t size = data; size + 10 < bytes.size(); ++size) {
      EXPECT_FALSE(ParsePly(bytes.substr(0, size)).ok()) << size;
    }
  }
  const auto odd = ParsePly(PlyHeaderOf("ascii") + "1 2 3 400\n5 6 7 8.0\n");
  ASSERT_TRUE(odd.ok()) << odd.status();
  EXPECT_THAT(Column(*odd, "intensity"), ElementsAre(0, 8));
}

std::string Las(uint8_t minor, uint8_t format, uint16_t record_length) {
  std::string bytes = "LASF";
  const uint32_t data_start = minor == 4 ? 375 : 227;
  Put<uint8_t>(bytes, 24, 1);
  Put<uint8_t>(bytes, 25, minor);
  Put<uint16_t>(bytes, 94, static_cast<uint16_t>(data_start));
  Put<uint32_t>(bytes, 96, data_start);
  Put<uint8_t>(bytes, 104, format);
  Put<uint16_t>(bytes, 105, record_length);
  Put<uint32_t>(bytes, 107, minor == 4 ? 0 : 2);
  for (int axis = 0; axis < 3; ++axis) {
    Put<double>(bytes, 131 + 8 * axis, 0.001);
    Put<double>(bytes, 155 + 8 * axis, 100 * axis);
  }
  if (minor == 4) Put<uint64_t>(bytes, 247, 2);
  for (int i = 0; i < 2; ++i) {
    const size_t at = data_start + i * record_length;
    for (int axis = 0; axis < 3; ++axis)
      Put<int32_t>(bytes, at + 4 * axis, 1000 * (axis + 1) * (1 - 2 * i));
    Put<uint16_t>(bytes, at + 12, static_cast<uint16_t>(500 + i));
    if (format == 1) Put<double>(bytes, at + 20, 7.5 + i);
    if (format == 6) Put<double>(bytes, at + 22, 7.5 + i);
    Put<char>(bytes, at + record_length - 1, 'x');
  }
  return bytes;
}

TEST(LasReader, ReadsOldAndNewFormats) {
  const struct {
    uint8_t minor, format;
    uint16_t length;
    bool has_time;
  } cases[] = {{2, 0, 21, false}, {2, 1, 40, true}, {4, 6, 31, true}};
  for (const auto& c : cases) {
    const auto las = ParseLas(Las(c.minor, c.format, c.length));
    ASSERT_TRUE(las.ok()) << las.status();
    EXPECT_THAT(Column(*las, "x"), ElementsAre(DoubleNear(1, 1e-9), DoubleNear(-1, 1e-9)));
    EXPECT_THAT(Column(*las, "y"), ElementsAre(DoubleNear(102, 1e-9), DoubleNear(98, 1e-9)));
    EXPECT_THAT(Column(*las, "z"), ElementsAre(DoubleNear(203, 1e-9), DoubleNear(197, 1e-9)));
    EXPECT_THAT(Column(*las, "intensity"), ElementsAre(500, 501));
    if (!c.has_time) continue;
    EXPECT_THAT(Column(*las, "time"), ElementsAre(7.5, 8.5));
  }
}

// A file of format 0 with that record of "LASF_Projection" before its points, or behind them.
std::string LasWith(uint16_t id, const std::string& data, bool is_extended = false) {
  const std::string las = Las(is_extended ? 4 : 2, 0, 21);
  const size_t header = is_extended ? 375 : 227;
  std::string record(is_extended ? 60 : 54, '\0');
  record.replace(2, 15, "LASF_Projection");
  Put<uint16_t>(record, 18, id);
  Put<uint16_t>(record, 20, static_cast<uint16_t>(data.size()));
  record += data;
  std::string bytes =
      is_extended ? las + record : las.substr(0, header) + record + las.substr(header);
  if (is_extended) {
    Put<uint64_t>(bytes, 235, las.size());
    Put<uint32_t>(bytes, 243, 1);
  } else {
    Put<uint32_t>(bytes, 96, static_cast<uint32_t>(header + record.size()));
    Put<uint32_t>(bytes, 100, 1);
  }
  return bytes;
}

const char kGeographic[] =
    "GEOGCS[\"NAD83\",DATUM[\"D\",SPHEROID[\"S\",6378137,298.257]],UNIT[\"degree\",0.0174532925]]";

// The first point is 1, 102, 203 in the file's units.
void ExpectPlace(const std::string& las, double unit, double vertical_unit) {
  const auto cloud = ParseLas(las);
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_NEAR(Column(*cloud, "x")[0], unit, 1e-9);
  EXPECT_NEAR(Column(*cloud, "y")[0], 102 * unit, 1e-9);
  EXPECT_NEAR(Column(*cloud, "z")[0], 203 * vertical_unit, 1e-9);
}

TEST(LasReader, ConvertsFeetOfWktToMetres) {
  const double us_foot = 1200.0 / 3937, foot = 0.3048;
  const std::string projected = std::string("PROJCS[\"Oregon, South (ftUS)\",") + kGeographic +
                                ",PROJECTION[\"X\"],PARAMETER[\"p\",2],";
  const std::string us_feet = projected + "UNIT[\"US survey foot\",0.30480060960121924]]";
  const std::string metres = projected + "UNIT[\"metre\",1,AUTHORITY[\"EPSG\",\"9001\"]]]";
  const std::string vertical = ",VERT_CS[\"v\",VERT_DATUM[\"d\",2005],UNIT[\"foot\",0.3048]]]";
  for (const bool is_extended : {false, true}) {
    const auto las = [&](const std::string& wkt) { return LasWith(2112, wkt, is_extended); };
    ExpectPlace(las(us_feet + std::string(1, '\0')), us_foot, us_foot);
    ExpectPlace(las(metres), 1, 1);
    ExpectPlace(las("COMPD_CS[\"c\"," + us_feet + vertical), us_foot, foot);
    ExpectPlace(las("COMPD_CS[\"c\"," + metres + vertical), 1, foot);
    ExpectPlace(
        las("PROJCRS[\"w2\",BASEGEOGCRS[\"b\",CS[ellipsoidal,2],ANGLEUNIT[\"degree\",0.01]],"
            "CS[Cartesian,2],AXIS[\"(E)\",east],LENGTHUNIT[\"foot\",0.3048]]"),
        foot, foot);
    ExpectPlace(
        las("BOUNDCRS[SOURCECRS[PROJCRS[\"w2\",CS[Cartesian,2],AXIS[\"(E)\",east,LENGTHUNIT["
            "\"foot\",0.3048]]]],TARGETCRS[GEOGCRS[\"t\",CS[ellipsoidal,2]]]]"),
        foot, foot);
    for (const char* none : {"", "[", "]]", "PROJCS", "PROJCS[\"cut off", "PROJCS[UNIT[\"m\",0]]",
                             "PROJCS[UNIT[\"m\",nan]]", "SOURCECRS[]", "COMPD_CS[SOURCECRS[]]"}) {
      ExpectPlace(las(none), 1, 1);
    }
    ExpectPlace(las(std::string(60'000, '[')), 1, 1);
  }
}

std::string GeoKeys(const std::vector<std::array<uint16_t, 4>>& keys) {
  std::string bytes;
  const uint16_t head[] = {1, 1, 0, static_cast<uint16_t>(keys.size())};
  bytes.append(reinterpret_cast<const char*>(head), sizeof(head));
  for (const auto& key : keys) bytes.append(reinterpret_cast<const char*>(key.data()), 8);
  return bytes;
}

TEST(LasReader, ConvertsFeetOfGeoKeysToMetres) {
  const double us_foot = 1200.0 / 3937, foot = 0.3048;
  ExpectPlace(LasWith(34735, GeoKeys({{1024, 0, 1, 1}, {3076, 0, 1, 9003}})), us_foot, us_foot);
  ExpectPlace(LasWith(34735, GeoKeys({{3076, 0, 1, 9002}, {4099, 0, 1, 9001}})), foot, 1);
  ExpectPlace(LasWith(34735, GeoKeys({{3076, 0, 1, 9001}, {4099, 0, 1, 9003}})), 1, us_foot);
  ExpectPlace(LasWith(34735, GeoKeys({{3072, 0, 1, 32632}})), 1, 1);
  ExpectPlace(LasWith(34735, GeoKeys({{3076, 0, 1, 32767}, {3077, 34736, 1, 9}})), 1, 1);
  ExpectPlace(LasWith(34735, "odd"), 1, 1);
}

TEST(LasReader, RefusesDegrees) {
  const std::string compound =
      std::string("COMPD_CS[\"c\",") + kGeographic + ",VERT_CS[\"v\",UNIT[\"metre\",1]]]";
  const std::string world = "GEOGCRS[\"WGS 84\",CS[ellipsoidal,3],AXIS[\"lat\",north]]";
  EXPECT_THAT(std::string(ParseLas(LasWith(2112, compound)).status().message()),
              HasSubstr("degrees of NAD83, not metres"));
  for (const std::string& las :
       {LasWith(2112, kGeographic), LasWith(2112, compound), LasWith(2112, world, true),
        LasWith(34735, GeoKeys({{1024, 0, 1, 2}, {2048, 0, 1, 4326}}))}) {
    EXPECT_THAT(std::string(ParseLas(las).status().message()), HasSubstr("degrees"));
  }
}

TEST(LasReader, RefusesWhatItCannotRead) {
  const std::string las = Las(4, 6, 30);
  const auto message = [](const std::string& bytes) {
    return std::string(ParseLas(bytes).status().message());
  };
  EXPECT_THAT(message(las.substr(0, las.size() - 1)), HasSubstr("truncated"));
  EXPECT_THAT(message("LASF"), HasSubstr("LAS header"));
  std::string laz = las;
  laz[104] = static_cast<char>(0x86);
  EXPECT_THAT(message(laz), HasSubstr("LAZ"));
  std::string short_records = las;
  Put<uint16_t>(short_records, 105, 0);
  EXPECT_THAT(message(short_records), HasSubstr("shorter"));
}

TEST(CloudFile, SaysWhatToDoAboutCompressedFormats) {
  for (const char* extension : {".laz", ".e57", ".E57"}) EXPECT_TRUE(IsCloudFile(extension));
  const std::string path = testing::TempDir() + "isthmus_cloud_file.e57";
  std::ofstream(path) << "ASTM-E57";
  EXPECT_THAT(std::string(ReadCloudFile(path).status().message()),
              HasSubstr("convert it to .las or .ply"));
  std::filesystem::remove(path);
}

TEST(TextCloud, ReadsWhatProgramsWrite) {
  const char* texts[] = {
      "1 2 3 0.5\n\n# a remark\n4\t5 6  0.25\r\n",
      "x,y,z,intensity\n1,2,3,0.5\n4,5,6,0.25\n",
      "//X Y Z scalar_Intensity\n1 2 3 0.5\n4 5 6 0.25\n",
      "\"intensity\",\"laser_id\",\"timestamp\",\"Points_m_XYZ:0\",\"Points_m_XYZ:1\","
      "\"Points_m_XYZ:2\"\n0.5,3,100,1,2,3\n0.25,4,101,4,5,6\n",
      "X (mm); Y (mm); Z (mm); I\n1000;2000;3000;0.5\n4000;+5000;6000;0.25\n",
      "\xEF\xBB\xBFx,y,z,intensity\r\n1,2,3,0.5\r\n4,5,6,0.25\r\n",
      "x,y,z,intensity,\n1,2,3,0.5,\n4,5,6,0.25,\n",
      "1;2;3;0.5;\n4;5;6;0.25;\n",
      "x,y,z,intensity,label\n1,2,3,0.5,wall\n4,5,6,0.25,\n",
      "label,x,y,z,intensity\n\"wall\",1,2,3,0.5\nfloor,4,5,6,0.25\n",
      "x\ty\tz\tnote\tintensity\n1\t2\t3\t\t0.5\n4\t5\t6\tby a door\t0.25\n",
      "x y z intensity\n1,2,3,0.5\n4,5,6,0.25\n",
      "\"x\",\"y\",\"z\",\"intensity\"\n\"1\",\"2\",\"3\",\"0.5\"\n4,5,6,0.25\n",
      "# intensity x y z\n0.5 1 2 3\n0.25 4 5 6\n",
      "// from the x y z scanner\n1 2 3 0.5\n// half of it\n4 5 6 0.25\n",
      "2\n1 2 3 0.5\n4 5 6 0.25\n",
      "//X Y Z Intensity\n2\n1 2 3 0.5\n4 5 6 0.25\n",
      "1\r\n1 2 3 0.5 90\r\n1\r\n4 5 6 0.25 91\r\n",
  };
  for (const char* text : texts) {
    const auto cloud = ParseText(text);
    ASSERT_TRUE(cloud.ok()) << text << cloud.status();
    EXPECT_THAT(Column(*cloud, "x"), ElementsAre(1, 4)) << text;
    EXPECT_THAT(Column(*cloud, "y"), ElementsAre(2, 5)) << text;
    EXPECT_THAT(Column(*cloud, "z"), ElementsAre(3, 6)) << text;
    EXPECT_THAT(Column(*cloud, "intensity"), ElementsAre(0.5, 0.25)) << text;
  }
}

TEST(TextCloud, LeavesColumnsOfWordsOutAndEmptyCellsAreNoNumbers) {
  const auto cloud = ParseText("time,x,y,z,n\nnoon,1,2,3,\nlater,,5,6,4\n");
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  ASSERT_EQ(cloud->fields.size(), 4u);
  EXPECT_EQ(codec::FindField(*cloud, {"time"}), nullptr);
  EXPECT_THAT(Column(*cloud, "z"), ElementsAre(3, 6));
  EXPECT_TRUE(std::isnan(Column(*cloud, "n")[0]) && Column(*cloud, "n")[1] == 4);
  EXPECT_TRUE(std::isnan(Column(*cloud, "x")[1]) && Column(*cloud, "x")[0] == 1);
}

TEST(TextCloud, NamesTheLineThatIsWrong) {
  const auto message = [](const std::string& text) {
    return std::string(ParseText(text).status().message());
  };
  EXPECT_THAT(message("1 2 3\n4 5\n"), HasSubstr("line 2: 2 values, not 3"));
  EXPECT_THAT(message("1 2 3\n4 five 6\n"), HasSubstr("line 2: 'five' is no number"));
  EXPECT_THAT(message("a,b,c\n1,2,3\n"), HasSubstr("line 1: no column is named x"));
  EXPECT_THAT(message("1 2 3\n4\n"), HasSubstr("line 2: 1 values, not 3"));
  EXPECT_THAT(message("x,y,z\n1,2,3,4\n"), HasSubstr("line 2: 4 values, not 3"));
  EXPECT_THAT(message("car 1 2 3\n"), HasSubstr("line 1: 'car' is no number"));
  EXPECT_THAT(message("\n#\n"), HasSubstr("no rows"));
  EXPECT_THAT(message("1 2\n"), HasSubstr("fewer than three"));
}

}  // namespace
}  // namespace isthmus::formats
