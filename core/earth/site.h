// The site's frame on the Earth: what a datum says of any point of the map.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <memory>
#include <string>

#include "core/map/datum.h"

namespace isthmus::earth {

// WGS 84: degrees, metres above the ellipsoid.
struct Geodetic {
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0;
};

// Conversions are those of GeographicLib, exact to nanometres: the frame is a plane that touches
// the ellipsoid at the datum's height (local Cartesian coordinates), turned by its heading, so far
// from the datum the ground falls below z = 0 (8 cm at 1 km). Thread safe.
class Site {
 public:
  // InvalidArgument for a datum out of range, see CheckDatum.
  static absl::StatusOr<Site> Create(const Datum& datum);

  Geodetic ToGeodetic(const Eigen::Vector3d& map) const;
  Eigen::Vector3d ToMap(const Geodetic& place) const;
  const Datum& datum() const { return datum_; }

  // Easting, northing and height above the ellipsoid in the datum's UTM zone, for the whole site.
  // The zone has its own scale, 0.9996 to about 1.001, by which distances differ from the map's.
  Eigen::Vector3d ToUtm(const Eigen::Vector3d& map) const;
  // The zone's coordinate reference system as WKT 1 (OGC 01-009), as LAS has it. FailedPrecondition
  // beyond 84 degrees north or 80 south, where there are no zones.
  absl::StatusOr<std::string> UtmWkt() const;
  // "WGS 84 / UTM zone 32N".
  std::string UtmName() const;

 private:
  struct Earth;
  explicit Site(const Datum& datum);

  Datum datum_;
  int zone_ = 0;  // 1 to 60; 0 near the poles.
  double sin_heading_ = 0, cos_heading_ = 1;
  std::shared_ptr<const Earth> earth_;
};

}  // namespace isthmus::earth
