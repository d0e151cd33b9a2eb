// Point clouds, from and to the API's messages.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <vector>

#include "core/cloud.h"
#include "core/point_payload.h"
#include "isthmus/v1/types.pb.h"

namespace isthmus::convert {

v1::PointCloud ToMessage(PointPayload payload);
v1::PointCloud LayoutMessage(const PointPayload& payload);  // All but the data.
// Takes over the data. InvalidArgument when the encoding or a field's type is not one of the API's;
// whether the layout fits the data is left to core/codec.
absl::StatusOr<PointPayload> FromMessage(v1::PointCloud&& cloud);

// Points of the merged map: x y z intensity robot, RAW.
v1::PointCloud ToMessage(const std::vector<MapPoint>& points);
// DataLoss when the cloud is not laid out so.
absl::Status AppendPoints(const v1::PointCloud& cloud, std::vector<MapPoint>& points);

}  // namespace isthmus::convert
