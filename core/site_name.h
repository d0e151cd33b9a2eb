// Names of sites: the maps that one server keeps apart.
#pragma once

#include <absl/status/status.h>

#include <string>

namespace isthmus {

// The site whose map lies in the data folder itself.
inline constexpr char kDefaultSite[] = "default";

// InvalidArgument unless it is up to 64 of [A-Za-z0-9_.-], no dot in front: it names a folder, and
// a schema of a database.
absl::Status CheckSiteName(const std::string& name);

}  // namespace isthmus
