// Whole files, with errors that say which file and why.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <string>

namespace isthmus::io {

// The meaning of errno, as "cannot ACTION PATH: why": NotFound, PermissionDenied,
// FailedPrecondition (a directory), ResourceExhausted (the disk is full) or Unavailable.
absl::Status FileError(const std::string& action, const std::string& path, int error);

// Errors of FileError.
absl::StatusOr<std::string> ReadFile(const std::string& path);

// Replaces the file. Likewise.
absl::Status WriteFile(const std::string& path, const std::string& bytes);

}  // namespace isthmus::io
