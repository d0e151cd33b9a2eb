// The merged map as a point cloud file.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <string>

#include "core/map/composed_map.h"

namespace isthmus::query {

enum class CloudFormat { kPcdAscii, kPcdBinary, kPcdBinaryCompressed, kPly };

// Receives the file's bytes piece by piece; returns false to stop (the reader went away).
using ByteSink = std::function<bool(const std::string&)>;

// Fields x y z intensity (float32, map frame, metres), robot (uint32, index into map.robots(),
// which the header lists as comments) and label (uint32, a PointClass). PLY is binary little
// endian. Memory is bounded by a piece of about half a MB, but for kPcdBinaryCompressed, which
// holds all points at once.
//
// A region that holds no point gives a file of none. Cancelled when the sink stopped it;
// ResourceExhausted when binary_compressed cannot hold so many points (214 million); whatever
// ComposedMap::Read says, the file then being incomplete. Thread safe; the sink is called from the
// calling thread.
absl::Status ExportCloud(const ComposedMap& map, const Region& region, CloudFormat format,
                         const ByteSink& sink);

}  // namespace isthmus::query
