// Whole files, with errors that say which file and why.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <string>

namespace isthmus::codec {

// NotFound, PermissionDenied, FailedPrecondition (a directory) or Unavailable.
absl::StatusOr<std::string> ReadFile(const std::string& path);

// Replaces the file. ResourceExhausted when the disk is full, else as ReadFile.
absl::Status WriteFile(const std::string& path, const std::string& bytes);

}  // namespace isthmus::codec
