// Queries of the merged map and their answers, from and to the API's messages.
#pragma once

#include <absl/status/statusor.h>

#include "core/records/map_info.h"
#include "core/records/map_reading.h"
#include "isthmus/v1/map_service.pb.h"

namespace isthmus::convert {

v1::MapInfo ToMessage(const MapInfo& info);
MapInfo FromMessage(const v1::MapInfo& info);

v1::Datum ToMessage(const Datum& datum);
Datum FromMessage(const v1::Datum& datum);
v1::ReplicaState ToMessage(const ReplicaState& state);
ReplicaState FromMessage(const v1::ReplicaState& state);

v1::Submap ToMessage(const SubmapStatus& status);
SubmapStatus FromMessage(const v1::Submap& submap);

v1::Frame ToMessage(TrajectoryFrame frame);
// InvalidArgument when none is named.
absl::StatusOr<TrajectoryFrame> FromMessage(v1::Frame frame);

v1::QueryRegionRequest ToMessage(const RegionQuery& query);
// InvalidArgument for a box with min > max, sizes that are not positive, too few or too many
// corners, a negative resolution, numbers that are not finite, and attributes or an encoding that
// are none.
absl::StatusOr<RegionQuery> FromMessage(const v1::QueryRegionRequest& request);

v1::RegionPosition ToMessage(const RegionPosition& position);
RegionPosition FromMessage(const v1::RegionPosition& position);

v1::ExportMapRequest ToMessage(const ExportRequest& request);
// InvalidArgument when no format is named, and for a resolution as above.
absl::StatusOr<ExportRequest> FromMessage(const v1::ExportMapRequest& request);

}  // namespace isthmus::convert
