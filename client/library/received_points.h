// Points of the merged map as they come from the server. Private to the library.
#pragma once

#include <absl/status/status.h>

#include <vector>

#include "core/cloud.h"
#include "isthmus/v1/types.pb.h"

namespace isthmus::client {

// Takes over the cloud's data; raw, quantised or by Draco. DataLoss for what is no points of a map.
absl::Status AppendReceived(v1::PointCloud&& cloud, std::vector<MapPoint>* points);

}  // namespace isthmus::client
