// Localisation, from and to the API's messages.
#pragma once

#include <absl/status/statusor.h>

#include "core/records/localisation.h"
#include "core/records/robot_place.h"
#include "isthmus/v1/localisation_service.pb.h"

namespace isthmus::convert {

v1::LocaliseBegin ToMessage(const LocalisationRequest& request);
// InvalidArgument for an extrinsic that is no pose and an odometry that is not known.
absl::StatusOr<LocalisationRequest> FromMessage(const v1::LocaliseBegin& begin);

v1::LocaliseResponse ToMessage(const LocalisedScan& scan);
LocalisedScan FromMessage(const v1::LocaliseResponse& response);

v1::Localising ToMessage(const Localising& localising);
Localising FromMessage(const v1::Localising& message);

}  // namespace isthmus::convert
