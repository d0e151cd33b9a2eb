// The mark of errors that are of a file or folder here, whatever their code: programs have an exit
// code for it.
#pragma once

#include <absl/status/status.h>

namespace isthmus::io {

inline constexpr char kOfFile[] = "isthmus/of-file";

inline absl::Status OfFile(absl::Status status) {
  status.SetPayload(kOfFile, {});
  return status;
}

}  // namespace isthmus::io
