#include "server/main/failed_call_log.h"

#include <absl/strings/str_cat.h>

#include <algorithm>

#include "core/plain_text.h"

namespace isthmus::server {
namespace {

// A line tells what a client did wrong; after some a person has seen it.
constexpr double kLinesAtOnce = 50, kLinesPerSecond = 5;
constexpr size_t kMaxLine = 300;

}  // namespace

bool FailedCallLog::TakeTurn() {
  const int64_t now_ns = clock_.NowNs();
  // A clock that was set back refills nothing.
  const double passed_s = static_cast<double>(std::max<int64_t>(now_ns - refilled_ns_, 0)) * 1e-9;
  lines_ = started_ ? std::min(kLinesAtOnce, lines_ + passed_s * kLinesPerSecond) : kLinesAtOnce;
  started_ = true;
  refilled_ns_ = now_ns;
  if (lines_ < 1) return false;
  lines_ -= 1;
  return true;
}

void FailedCallLog::Note(const rpc::FailedCall& call) {
  MutexLock lock(&mutex_);
  if (!TakeTurn()) {
    ++left_out_;
    return;
  }
  std::string line = absl::StrCat(call.rpc, ": ", absl::StatusCodeToString(call.status.code()),
                                  ": ", LineOf(call.status.message(), kMaxLine));
  if (left_out_ > 0) absl::StrAppend(&line, " (", left_out_, " more failed calls before it)");
  left_out_ = 0;
  write_(call, line);
}

}  // namespace isthmus::server
