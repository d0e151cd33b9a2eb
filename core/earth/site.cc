#include "core/earth/site.h"

#include <absl/strings/str_cat.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <GeographicLib/TransverseMercator.hpp>
#include <GeographicLib/UTMUPS.hpp>
#include <cmath>
#include <numbers>

namespace isthmus::earth {
namespace {

constexpr double kFalseEasting = 500'000, kFalseNorthingSouth = 10'000'000;  // Math: of UTM, m.

}  // namespace

struct Site::Earth {
  explicit Earth(const Datum& datum)
      : plane(datum.latitude_deg, datum.longitude_deg, datum.altitude_m) {}
  const GeographicLib::LocalCartesian plane;
};

Site::Site(const Datum& datum) : datum_(datum), earth_(std::make_shared<const Earth>(datum)) {
  zone_ = GeographicLib::UTMUPS::StandardZone(datum.latitude_deg, datum.longitude_deg);
  const double heading = datum.heading_deg * std::numbers::pi / 180;
  sin_heading_ = std::sin(heading);
  cos_heading_ = std::cos(heading);
}

absl::StatusOr<Site> Site::Create(const Datum& datum) {
  if (absl::Status status = CheckDatum(datum); !status.ok()) return status;
  return Site(datum);
}

Geodetic Site::ToGeodetic(const Eigen::Vector3d& map) const {
  const double east = map.x() * cos_heading_ + map.y() * sin_heading_;
  const double north = map.y() * cos_heading_ - map.x() * sin_heading_;
  Geodetic place;
  earth_->plane.Reverse(east, north, map.z(), place.latitude_deg, place.longitude_deg,
                        place.altitude_m);
  return place;
}

Eigen::Vector3d Site::ToMap(const Geodetic& place) const {
  double east = 0, north = 0, up = 0;
  earth_->plane.Forward(place.latitude_deg, place.longitude_deg, place.altitude_m, east, north, up);
  return {east * cos_heading_ - north * sin_heading_, north * cos_heading_ + east * sin_heading_,
          up};
}

Eigen::Vector3d Site::ToUtm(const Eigen::Vector3d& map) const {
  const Geodetic place = ToGeodetic(map);
  double easting = 0, northing = 0;
  // Not UTMUPS, which refuses points beyond the edge of the zone and changes hemisphere at the
  // equator: one site has one system.
  GeographicLib::TransverseMercator::UTM().Forward(6 * zone_ - 183, place.latitude_deg,
                                                   place.longitude_deg, easting, northing);
  const double false_northing = datum_.latitude_deg < 0 ? kFalseNorthingSouth : 0;
  return {easting + kFalseEasting, northing + false_northing, place.altitude_m};
}

std::string Site::UtmName() const {
  return absl::StrCat("WGS 84 / UTM zone ", zone_, datum_.latitude_deg < 0 ? "S" : "N");
}

absl::StatusOr<std::string> Site::UtmWkt() const {
  if (zone_ < 1) {
    return absl::FailedPreconditionError(
        "there are no UTM zones beyond 84 degrees north and 80 south: clear the datum to export in "
        "the map's own coordinates");
  }
  const bool is_south = datum_.latitude_deg < 0;
  const auto epsg = [](int code) { return absl::StrCat("AUTHORITY[\"EPSG\",\"", code, "\"]"); };
  return absl::StrCat("PROJCS[\"", UtmName(), "\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",",
                      "SPHEROID[\"WGS 84\",6378137,298.257223563,", epsg(7030), "],", epsg(6326),
                      "],PRIMEM[\"Greenwich\",0,", epsg(8901),
                      "],UNIT[\"degree\",0.0174532925199433,", epsg(9122), "],", epsg(4326),
                      "],PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],",
                      "PARAMETER[\"central_meridian\",", 6 * zone_ - 183,
                      "],PARAMETER[\"scale_factor\",0.9996],",
                      "PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",",
                      is_south ? 10'000'000 : 0, "],UNIT[\"metre\",1,", epsg(9001),
                      "],AXIS[\"Easting\",EAST],AXIS[\"Northing\",NORTH],",
                      epsg((is_south ? 32700 : 32600) + zone_), "]");
}

}  // namespace isthmus::earth
