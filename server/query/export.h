// The merged map as a point cloud file.
#pragma once

#include <absl/status/status.h>

#include <functional>
#include <string>

#include "core/composed_map.h"

namespace isthmus::query {

enum class CloudFormat { kPcdAscii, kPcdBinary, kPcdBinaryCompressed, kPly };

// Receives the file's bytes piece by piece; returns false to stop (the reader went away).
using ByteSink = std::function<bool(const std::string&)>;

// Fields x y z intensity robot. Cancelled when the sink stopped it.
absl::Status ExportCloud(const ComposedMap& map, const Region& region,
                         CloudFormat format, const ByteSink& sink);

}  // namespace isthmus::query
