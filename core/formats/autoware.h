// The cells of a map as Autoware's map loader takes them: squares of whole metres, a PCD file each.
#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace isthmus::formats {

// The lower corner of a cell, metres.
using CellCorner = std::pair<int64_t, int64_t>;

// "-20_40.pcd".
std::string CellFileName(const CellCorner& corner);
// The corner of the cell of exactly that file name, within 32 bits; absent for any other text.
std::optional<CellCorner> ReadCellFileName(absl::string_view name);
// pointcloud_map_metadata.yaml of cells with edges of so many metres.
std::string FormatCellList(int64_t edge_m, const std::vector<CellCorner>& corners);

}  // namespace isthmus::formats
