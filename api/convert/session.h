// Sessions, their scans and uploads, from and to the API's messages.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "core/map/session.h"
#include "core/odometry_mode.h"
#include "core/records/session_status.h"
#include "core/records/submap_upload.h"
#include "core/scan_upload.h"
#include "core/tracking.h"
#include "isthmus/v1/session_service.pb.h"

namespace isthmus::convert {

v1::CreateSessionRequest ToMessage(const SessionRequest& request);
// InvalidArgument for an extrinsic that is no pose and an odometry that is not known.
absl::StatusOr<SessionRequest> FromMessage(const v1::CreateSessionRequest& request);

v1::Odometry ToMessage(const std::optional<OdometryMode>& mode);
// InvalidArgument for one that is not known.
absl::StatusOr<std::optional<OdometryMode>> Checked(v1::Odometry odometry);
v1::Tracking ToMessage(Tracking tracking);
Tracking FromMessage(v1::Tracking tracking);

v1::Session ToMessage(const SessionStatus& status);
SessionStatus FromMessage(const v1::Session& session);

v1::ScanCounts ToMessage(const ScanCounts& counts);
ScanCounts FromMessage(const v1::ScanCounts& counts);

// Without the session and the scan's stamp, which who sent it knows.
v1::StreamScansResponse ToMessage(const ScanAck& ack);
ScanAck FromMessage(const v1::StreamScansResponse& ack);

// With the size and checksums of the cloud's data, but without the data.
v1::UploadSubmapHeader ToMessage(const SubmapUpload& submap);
// Takes over the cloud, its data included. InvalidArgument for what is no pose, and as for a cloud.
absl::StatusOr<SubmapUpload> FromMessage(v1::UploadSubmapHeader&& header);

}  // namespace isthmus::convert
