#include "client/console/exit_code.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <cstdio>
#include <string>

#include "core/plain_text.h"

namespace isthmus::cli {
namespace {

constexpr absl::string_view kOfFile = "isthmus/of-file";

}  // namespace

absl::Status OfFile(absl::Status status) {
  status.SetPayload(kOfFile, {});
  return status;
}

ExitCode ServerExit(const absl::Status& status) {
  if (status.GetPayload(kOfFile)) return kInput;
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
  std::string text;
  for (const absl::string_view line : absl::StrSplit(status.message(), '\n')) {
    absl::StrAppend(&text, text.empty() ? "" : "\n", LineOf(line, kLongestLine));
  }
  std::fprintf(stderr, "isthmus: %s\n", text.c_str());
  return code;
}

}  // namespace isthmus::cli
