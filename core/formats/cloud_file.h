// Clouds that other programs write: PLY, LAS and rows of numbers.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "core/point_payload.h"

namespace isthmus::formats {

// All give a raw payload with the fields of the file in its order and under its names, but that
// what is known to be x, y, z, intensity, ring or time is called so. A value of another field than
// x, y and z that its type cannot hold is NaN or 0 (number_text.h). InvalidArgument, naming what is
// wrong, for bytes that are none of that format or are damaged; what is allocated is bounded by the
// size of `bytes`. An empty cloud is no error.

// Polygon File Format (Turk 1994), ascii and binary of either byte order: the element "vertex".
// Other elements, faces for one, and lists are passed over; 8-byte integers become float64.
// CloudCompare's "scalar_" goes from names.
absl::StatusOr<PointPayload> ParsePly(const std::string& bytes);

// LAS 1.0 to 1.4 (ASPRS), point formats 0 to 10, without waveforms: x y z (float64, scaled and
// offset), intensity (uint16), and time (float64, GPS seconds as the file has them) where there is
// one. Feet, and other units that its coordinate reference system names (las_units.h), become
// metres. Refused are degrees, and LAZ, which is compressed.
absl::StatusOr<PointPayload> ParseLas(const std::string& bytes);

// A point per line, its numbers (float64) parted by semicolons, commas, tabs or spaces; one may
// stand behind the last, too. A first line of names, also as a remark, says what they are, as
// VeloView, CloudCompare and Ouster write them ("Points_m_XYZ:0", "//X", "X (mm)"); without one
// they are x y z [intensity]. Skipped are a byte-order mark, the number of points in front of them
// (.pts), empty lines and those that begin with # or //. A cell that is empty is NaN, and so is a
// word, but for x, y and z; a column without any number is left out.
absl::StatusOr<PointPayload> ParseText(const std::string& bytes);

// Reads the file, of a format that its extension tells: .pcd, .ply, .las, or .csv, .txt, .xyz, .asc
// and .pts for rows of numbers. NotFound, PermissionDenied or Unavailable when it cannot be read;
// messages carry the path.
absl::StatusOr<PointPayload> ReadCloudFile(const std::string& path);
// True if ReadCloudFile knows the extension (".ply", of either case): also .laz and .e57, of which
// it says what to do.
bool IsCloudFile(const std::string& extension);
bool IsTextFile(const std::string& extension);

}  // namespace isthmus::formats
