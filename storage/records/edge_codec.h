// The edges of a match or a loop closure as one checksummed blob; docs/storage-format.md describes
// the bytes.
#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

#include "core/map/match.h"

namespace isthmus::storage {

std::string EncodeEdges(const std::vector<SubmapEdge>& edges);

// DataLoss, naming the fault, for anything EncodeEdges did not make of edges with finite poses and
// information. `edges` are then to be thrown away. Never allocates more than the blob justifies.
absl::Status DecodeEdges(const std::string& blob, std::vector<SubmapEdge>& edges);

}  // namespace isthmus::storage
