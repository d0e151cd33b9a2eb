// Places on the Earth against published ones, and there and back.
#include "core/earth/site.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace isthmus::earth {
namespace {

constexpr Datum kMunich{.latitude_deg = 48.137, .longitude_deg = 11.575, .altitude_m = 520};

Site SiteAt(const Datum& datum) { return *Site::Create(datum); }

// Earth-centred coordinates by the closed formula, with WGS 84's axes.
Eigen::Vector3d EarthCentred(const Geodetic& place) {
  constexpr double kA = 6378137, kF = 1 / 298.257223563, kE2 = kF * (2 - kF);
  const double lat = place.latitude_deg * std::numbers::pi / 180;
  const double lon = place.longitude_deg * std::numbers::pi / 180;
  const double n = kA / std::sqrt(1 - kE2 * std::sin(lat) * std::sin(lat));
  return {(n + place.altitude_m) * std::cos(lat) * std::cos(lon),
          (n + place.altitude_m) * std::cos(lat) * std::sin(lon),
          (n * (1 - kE2) + place.altitude_m) * std::sin(lat)};
}

TEST(Site, DistancesOnTheEarthAreThoseOfTheMap) {
  const Site site = SiteAt(kMunich);
  const Eigen::Vector3d a(100, -2000, 7), b(-3500, 900, -12);
  const Eigen::Vector3d way = EarthCentred(site.ToGeodetic(a)) - EarthCentred(site.ToGeodetic(b));
  EXPECT_NEAR(way.norm(), (a - b).norm(), 1e-6);
}

TEST(Site, ThereAndBackIsTheSamePlace) {
  for (const double heading : {0.0, 37.0, -250.0}) {
    Datum datum = kMunich;
    datum.heading_deg = heading;
    const Site site = SiteAt(datum);
    const Eigen::Vector3d map(1234.5, -678.9, 12.3);
    EXPECT_LT((site.ToMap(site.ToGeodetic(map)) - map).norm(), 1e-6);
  }
}

TEST(Site, AHeadingTurnsTheMapsYAxisFromNorthToEast) {
  Datum datum = kMunich;
  datum.heading_deg = 90;
  const Geodetic ahead = SiteAt(datum).ToGeodetic({0, 100, 0});
  EXPECT_NEAR(ahead.latitude_deg, kMunich.latitude_deg, 1e-7);
  EXPECT_GT(ahead.longitude_deg, kMunich.longitude_deg + 1e-3);
  const Geodetic right = SiteAt(datum).ToGeodetic({100, 0, 0});
  EXPECT_LT(right.latitude_deg, kMunich.latitude_deg - 8e-4) << "x then points south";
}

TEST(Site, UtmIsThatOfTheZone) {
  // On the central meridian of zone 32 (9 degrees east) the easting is 500 km, and the northing
  // 0.9996 times the arc of the meridian: 5,540,847.04 m to 50 degrees (WGS 84).
  const Site site = SiteAt({.latitude_deg = 50, .longitude_deg = 9, .altitude_m = 100});
  const Eigen::Vector3d utm = site.ToUtm({0, 0, 5});
  EXPECT_NEAR(utm.x(), 500'000, 1e-6);
  EXPECT_NEAR(utm.y(), 0.9996 * 5'540'847.04, 0.02);
  EXPECT_NEAR(utm.z(), 105, 1e-6);
  EXPECT_EQ(site.UtmName(), "WGS 84 / UTM zone 32N");
  EXPECT_NEAR((site.ToUtm({100, 0, 0}) - site.ToUtm({0, 0, 0})).norm(), 99.96, 0.01);
  EXPECT_THAT(*site.UtmWkt(), testing::HasSubstr("AUTHORITY[\"EPSG\",\"32632\"]]"));
}

TEST(Site, SouthOfTheEquatorNorthingsBeginAtTenMillion) {
  const Site site = SiteAt({.latitude_deg = -33.86, .longitude_deg = 151.2});
  EXPECT_EQ(site.UtmName(), "WGS 84 / UTM zone 56S");
  EXPECT_THAT(*site.UtmWkt(), testing::HasSubstr("\"false_northing\",10000000]"));
  EXPECT_NEAR(site.ToUtm({0, 0, 0}).y(), 6.25e6, 1e4);
  const Site equator = SiteAt({.latitude_deg = 0.0001, .longitude_deg = 3});
  EXPECT_LT(equator.ToUtm({0, -100, 0}).y(), 0) << "one site has one system";
}

TEST(Site, ThePolesHaveNoZone) {
  EXPECT_TRUE(absl::IsFailedPrecondition(SiteAt({.latitude_deg = 89}).UtmWkt().status()));
  EXPECT_TRUE(absl::IsInvalidArgument(Site::Create({.latitude_deg = 91}).status()));
}

}  // namespace
}  // namespace isthmus::earth
