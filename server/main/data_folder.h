// The folder the map lives in.
#pragma once

#include <absl/status/status.h>

#include <string>

namespace isthmus::server {

// Makes the folder and its parents where missing. FailedPrecondition when that cannot be done or a
// file cannot be written in it; the message says why.
absl::Status MakeDataFolder(const std::string& path);

}  // namespace isthmus::server
