#include "client/console/exit_code.h"

#include <cstdio>
#include <string>

namespace isthmus::cli {

ExitCode ServerExit(const absl::Status& status) {
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
  std::fprintf(stderr, "isthmus: %s\n", std::string(status.message()).c_str());
  return code;
}

}  // namespace isthmus::cli
