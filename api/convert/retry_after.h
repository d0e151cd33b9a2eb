// The time at which a refused caller may come again, as part of a status.
#pragma once

#include <absl/status/status.h>

#include <chrono>
#include <optional>
#include <string>

namespace isthmus::convert {

// The same status with google.rpc.RetryInfo as a payload.
absl::Status WithRetryAfter(absl::Status status, std::chrono::milliseconds after);

// Nothing where the status does not say.
std::optional<std::chrono::milliseconds> RetryAfter(const absl::Status& status);

// google.rpc.Status in bytes, with all payloads: what travels as `grpc-status-details-bin`. Empty
// where there are none.
std::string StatusDetails(const absl::Status& status, const std::string& message);
// The same status with the payloads of such bytes; bytes that are none add nothing.
absl::Status WithDetails(absl::Status status, const std::string& details);

}  // namespace isthmus::convert
