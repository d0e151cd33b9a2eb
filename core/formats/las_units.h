// The units of the coordinates of a LAS file, as its coordinate reference system tells them.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

namespace isthmus::formats {

// Metres per unit.
struct LasUnits {
  double horizontal_m = 1, vertical_m = 1;
};

// The units of WKT 1 (OGC 01-009) and WKT 2 (OGC 18-010): those of the projection, and of its
// vertical system if one is named, else the same. Metres for any other text, and for one that names
// none. InvalidArgument for degrees: a geographic system.
absl::StatusOr<LasUnits> UnitsOfWkt(absl::string_view wkt);

// The same of the record GeoKeyDirectoryTag (GeoTIFF 1.1, OGC 19-008, section 7), `doubles` being
// GeoDoubleParamsTag. A system that is named by its number alone tells no units.
absl::StatusOr<LasUnits> UnitsOfGeoKeys(absl::string_view directory, absl::string_view doubles);

}  // namespace isthmus::formats
