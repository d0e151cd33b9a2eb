#include "server/main/failed_call_log.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <map>

#include "core/plain_text.h"

namespace isthmus::server {
namespace {

// A line tells what a client did wrong; after some a person has seen it.
constexpr double kLinesAtOnce = 50, kLinesPerSecond = 5;
constexpr size_t kMaxLine = 300;
// A client that tries again every second is told of once in so long.
constexpr int64_t kRepeat_ns = 60'000'000'000;

}  // namespace

bool FailedCallLog::TakeTurn(int64_t now_ns) {
  // A clock that was set back refills nothing.
  const double passed_s = static_cast<double>(std::max<int64_t>(now_ns - refilled_ns_, 0)) * 1e-9;
  lines_ = started_ ? std::min(kLinesAtOnce, lines_ + passed_s * kLinesPerSecond) : kLinesAtOnce;
  started_ = true;
  refilled_ns_ = now_ns;
  if (lines_ < 1) return false;
  lines_ -= 1;
  return true;
}

bool FailedCallLog::IsSaid(const std::string& line, int64_t now_ns) {
  // By a clock that was set back it was said in the future.
  const auto is_over = [now_ns](const auto& said) {
    return now_ns < said.second || now_ns - said.second >= kRepeat_ns;
  };
  std::erase_if(said_ns_, is_over);
  return said_ns_.contains(line);
}

void FailedCallLog::Note(const rpc::FailedCall& call) {
  std::string line = absl::StrCat(call.rpc, ": ", absl::StatusCodeToString(call.status.code()),
                                  ": ", LineOf(call.status.message(), kMaxLine));
  const std::string machine = call.peer.substr(0, call.peer.rfind(':'));  // Without its port.
  const std::string said = absl::StrCat(call.token, " ", machine, " ", line);
  MutexLock lock(&mutex_);
  const int64_t now_ns = clock_.NowNs();
  if (IsSaid(said, now_ns) || !TakeTurn(now_ns)) {
    ++left_out_;
    return;
  }
  said_ns_[said] = now_ns;  // Bounded, as are the lines of a minute.
  if (left_out_ > 0) absl::StrAppend(&line, " (", left_out_, " more failed calls before it)");
  left_out_ = 0;
  write_(call, line);
}

}  // namespace isthmus::server
