// An output as a person names it: a file that appears once it is complete, or a stream.
#pragma once

#include <absl/status/status.h>

#include <memory>
#include <optional>
#include <string>

#include "core/io/file_io.h"
#include "core/io/part_file.h"

namespace isthmus::io {

// "-", /dev/stdout, /dev/stderr, /dev/fd/N and /proc/self/fd/N are the descriptors that the program
// was started with; what is there and is neither file nor folder (a pipe, a terminal, a device) is
// written as it stands. None of these is ever renamed, removed or replaced. Everything else is
// written to PATH.part and renamed; where PATH is a link, what it leads to is replaced. Errors are
// FileError's. Not thread safe.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path);

  // Begins, or begins anew; FailedPrecondition for a stream of which something is written already.
  absl::Status Open();
  absl::Status Append(const std::string& bytes);
  absl::Status Commit();  // Complete. Without it no file appears.
  bool is_stream() const { return !part_.has_value(); }

 private:
  const std::string path_;
  std::optional<PartFile> part_;  // Unless a stream.
  std::optional<File> stream_;    // Once open.
  bool has_bytes_ = false;
};

// True for "-" and the other names of standard output.
bool IsStandardOutput(const std::string& path);

// The target of a link, so that the link itself stays; PATH if it is none.
std::string OutputTarget(const std::string& path);

// Checks that PATH can be opened for writing, as far as that can be told beforehand: NotFound if
// its folder is missing, PermissionDenied, FailedPrecondition if it is a folder itself.
absl::Status CheckOutput(const std::string& path);

// A whole output at once.
absl::Status WriteOutput(const std::string& path, const std::string& bytes);

}  // namespace isthmus::io
