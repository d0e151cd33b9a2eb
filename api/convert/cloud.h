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
// core/codec checks that the layout fits the data. Points sent to the server are not DRACO.
absl::StatusOr<PointPayload> FromMessage(v1::PointCloud&& cloud);
// The same for points that the server sends, which may be DRACO.
absl::StatusOr<PointPayload> FromServer(v1::PointCloud&& cloud);

// The fields that a point of the merged map is sent with, beside x y z.
struct MapPointFields {
  bool intensity = true, robot = true, stamp = false, label = false;
};
// Raw; fields x y z intensity robot label last_seen, those wanted.
PointPayload ToPayload(const std::vector<MapPoint>& points, const MapPointFields& wanted);
// Fields that were not sent are 0. DataLoss when the points are not laid out so.
absl::Status AppendPoints(const PointPayload& payload, std::vector<MapPoint>& points);

}  // namespace isthmus::convert
