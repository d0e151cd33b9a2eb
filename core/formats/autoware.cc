#include "core/formats/autoware.h"

#include <absl/strings/str_cat.h>

namespace isthmus::formats {

std::string CellFileName(const CellCorner& corner) {
  return absl::StrCat(corner.first, "_", corner.second, ".pcd");
}

std::string FormatCellList(int64_t edge_m, const std::vector<CellCorner>& corners) {
  std::string yaml = absl::StrCat("x_resolution: ", edge_m, ".0\ny_resolution: ", edge_m, ".0\n");
  for (const CellCorner& corner : corners) {
    absl::StrAppend(&yaml, CellFileName(corner), ": [", corner.first, ", ", corner.second, "]\n");
  }
  return yaml;
}

}  // namespace isthmus::formats
