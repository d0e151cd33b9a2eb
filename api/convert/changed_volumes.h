// Changes of the map that are asked for and told, from and to the API's messages.
#pragma once

#include <absl/status/statusor.h>

#include "core/records/changed_volumes.h"
#include "isthmus/v1/map_service.pb.h"

namespace isthmus::convert {

v1::FindChangesRequest ToMessage(const ChangeQuery& query);
// InvalidArgument without `since`, for a negative revision or size, numbers that are not finite,
// and for a region as FromMessage(QueryRegionRequest).
absl::StatusOr<ChangeQuery> FromMessage(const v1::FindChangesRequest& request);

v1::ChangedVolume ToMessage(const ChangedVolume& volume);
ChangedVolume FromMessage(const v1::ChangedVolume& volume);

}  // namespace isthmus::convert
