#include "core/formats/autoware.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <utility>

namespace isthmus::formats {

std::string CellFileName(const CellCorner& corner) {
  return absl::StrCat(corner.first, "_", corner.second, ".pcd");
}

std::optional<CellCorner> ReadCellFileName(absl::string_view name) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(absl::StripSuffix(name, ".pcd"), absl::MaxSplits('_', 1));
  int32_t x = 0, y = 0;
  if (!absl::SimpleAtoi(parts.first, &x) || !absl::SimpleAtoi(parts.second, &y)) {
    return std::nullopt;
  }
  const CellCorner corner(x, y);
  if (CellFileName(corner) != name) return std::nullopt;  // Spelt in another way: "+1_0.pcd".
  return corner;
}

std::string FormatCellList(int64_t edge_m, const std::vector<CellCorner>& corners) {
  std::string yaml = absl::StrCat("x_resolution: ", edge_m, ".0\ny_resolution: ", edge_m, ".0\n");
  for (const CellCorner& corner : corners) {
    absl::StrAppend(&yaml, CellFileName(corner), ": [", corner.first, ", ", corner.second, "]\n");
  }
  return yaml;
}

}  // namespace isthmus::formats
