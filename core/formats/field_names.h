// The names that programs give to the fields of a point.
#pragma once

#include <absl/strings/string_view.h>

#include <string>

namespace isthmus::formats {

// A column: what it holds by the words of this project where it is known, else as it is called; and
// metres per unit where it holds coordinates.
struct ColumnName {
  std::string name;
  double scale = 1;
};

// x, y or z, in either case: a point without one of them is none. All other fields may be missing,
// and so may their values.
bool IsAxis(absl::string_view name);

// "Points_m_XYZ:0", "//X" and "X (mm)" are x, "scalar_Intensity" is intensity, "laser_id" is ring.
ColumnName UnderstandColumn(absl::string_view called);

}  // namespace isthmus::formats
