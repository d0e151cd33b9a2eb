// The merged map as PCD or PLY, piece by piece, so that a large map needs no second copy in memory.
// Fields x y z intensity (float32), robot (uint32, index into the list of robots, which is written
// as comments) and label (uint32, a PointClass). A file is the header followed by its chunks.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/cloud.h"
#include "core/formats/pcd.h"
#include "core/ids.h"

namespace isthmus::formats {

// `points` is what the chunks will hold in total.
std::string PcdMapHeader(uint64_t points, PcdEncoding encoding,
                         const std::vector<RobotId>& robots = {});
// Rows for kAscii, records otherwise; kBinaryCompressed cannot be chunked, see below.
std::string PcdMapChunk(const std::vector<MapPoint>& points, PcdEncoding encoding);

// The data that follows the header of a binary_compressed file: all points at once, because PCL
// compresses field by field. ResourceExhausted above 4 GiB (214 million points), a limit of the
// format.
absl::StatusOr<std::string> PcdMapCompressed(const std::vector<MapPoint>& points);

// Binary little-endian PLY.
std::string PlyMapHeader(uint64_t points, const std::vector<RobotId>& robots = {});
std::string PlyMapChunk(const std::vector<MapPoint>& points);

}  // namespace isthmus::formats
