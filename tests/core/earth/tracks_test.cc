// The robots' ways over the Earth as other programs read them.
#include "core/earth/tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace isthmus::earth {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr Datum kDatum{.latitude_deg = 48.137, .longitude_deg = 11.575, .altitude_m = 520};

std::vector<Track> TwoTracks() {
  Track moving{RobotId("alice"), SessionId("alice-2"), {}};
  for (int i = 0; i < 3; ++i) {
    moving.poses.push_back({1'700'000'000'000'000'000 + i * 100'000'000,
                            Pose(Eigen::Quaterniond::Identity(), {10.0 * i, 0, 1})});
  }
  Track standing{RobotId("b&b"), SessionId("bob-1"), {moving.poses[0]}};
  return {moving, standing, {RobotId("carol"), SessionId("carol-1"), {}}};
}

TEST(EarthTracks, GeoJsonHasLongitudeFirst) {
  const auto site = *Site::Create(kDatum);
  const json file = json::parse(FormatGeoJson(TwoTracks(), site));
  EXPECT_EQ(file["type"], "FeatureCollection");
  ASSERT_EQ(file["features"].size(), 2u);
  const json& line = file["features"][0];
  EXPECT_EQ(line["properties"]["robot"], "alice");
  EXPECT_EQ(line["properties"]["session"], "alice-2");
  EXPECT_EQ(line["properties"]["begin"], "2023-11-14T22:13:20.000Z");
  EXPECT_EQ(line["properties"]["end"], "2023-11-14T22:13:20.200Z");
  EXPECT_EQ(line["geometry"]["type"], "LineString");
  const json& at = line["geometry"]["coordinates"];
  ASSERT_EQ(at.size(), 3u);
  EXPECT_NEAR(at[0][0].get<double>(), 11.575, 1e-9);
  EXPECT_NEAR(at[0][1].get<double>(), 48.137, 1e-9);
  EXPECT_NEAR(at[0][2].get<double>(), 521, 1e-3);
  // 20 m east at that latitude: 74.4 km to a degree.
  EXPECT_NEAR(at[2][0].get<double>(), 11.575 + 20 / 74'430.0, 1e-7);
  EXPECT_EQ(file["features"][1]["geometry"]["type"], "Point");
}

TEST(EarthTracks, KmlHasAPlacemarkPerTrack) {
  const auto site = *Site::Create(kDatum);
  const std::string kml = FormatKml(TwoTracks(), site);
  EXPECT_THAT(kml, HasSubstr("<name>alice</name>"));
  EXPECT_THAT(kml, HasSubstr("<name>b&amp;b</name>"));
  EXPECT_THAT(kml, HasSubstr("\n11.575000000,48.137000000,521.000\n"));
  EXPECT_THAT(kml, HasSubstr("<begin>2023-11-14T22:13:20.000Z</begin>"));
  EXPECT_TRUE(kml.starts_with("<?xml version=\"1.0\"")) << kml;
  EXPECT_TRUE(kml.ends_with("</Document>\n</kml>\n"));
}

}  // namespace
}  // namespace isthmus::earth
