#include "client/console/exit_code.h"

#include <cstdio>

#include "client/console/say.h"
#include "core/io/of_file.h"

namespace isthmus::cli {

ExitCode ServerExit(const absl::Status& status) {
  if (status.GetPayload(io::kOfFile)) return kInput;
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return kOk;
    case absl::StatusCode::kUnavailable:
      return kNotReachable;
    case absl::StatusCode::kNotFound:
      return kUnknown;
    case absl::StatusCode::kInvalidArgument:
      return kUsage;
    case absl::StatusCode::kFailedPrecondition:
      return kNoAnswer;
    default:
      return kFailed;
  }
}

int Fail(ExitCode code, const absl::Status& status) {
  // Names of files and robots come from anywhere; a terminal would obey some of them.
  constexpr size_t kLongestLine = 4000;
  std::fprintf(stderr, "isthmus: %s\n", Lines(status.message(), kLongestLine).c_str());
  return code;
}

int FailServer(const absl::Status& status) {
  const ExitCode code = ServerExit(status);
  if (code == kInput) return Fail(code, status);
  return Fail(code, absl::Status(status.code(), Printable(status.message())));
}

}  // namespace isthmus::cli
