// The site's datum as the server has it, where it holds for a component.
#pragma once

#include <absl/status/statusor.h>

#include <optional>

#include "client/georeference/site.h"
#include "client/library/client.h"

namespace isthmus::cli {

// The site in whose frame the component lies: with a datum, one that anchors hold, or, where there
// are no anchors at all, component 0. Absent for others, and says so on stderr where there is a
// datum.
absl::StatusOr<std::optional<georeference::Site>> ReadSite(client::Client& client,
                                                           uint32_t component);

// The datum; FailedPrecondition, saying how to set it, where there is none.
absl::StatusOr<georeference::Site> NeedSite(client::Client& client);

}  // namespace isthmus::cli
