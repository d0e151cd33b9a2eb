#include "server/main/failed_call_log.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>

namespace isthmus::server {
namespace {

// A line tells what a client did wrong; after some a person has seen it.
constexpr double kLinesAtOnce = 50, kLinesPerSecond = 5;
constexpr size_t kMaxLine = 300;

// Of the character that begins there, if it is one that a terminal obeys: its bytes; else 0.
size_t ControlAt(const std::string& text, size_t at) {
  const auto c = static_cast<unsigned char>(text[at]);
  if (c < 0x20 || c == 0x7F) return 1;
  // C1 controls are two bytes in UTF-8.
  const auto next = static_cast<unsigned char>(at + 1 < text.size() ? text[at + 1] : 0);
  return c == 0xC2 && next >= 0x80 && next < 0xA0 ? 2 : 0;
}

}  // namespace

std::string LineOf(const std::string& text, size_t most) {
  std::string line;
  for (size_t i = 0; i < text.size();) {
    const size_t control = ControlAt(text, i);
    std::string piece;
    for (size_t k = 0; k < control; ++k) {
      absl::StrAppendFormat(&piece, "\\x%02x", static_cast<unsigned char>(text[i + k]));
    }
    if (control == 0) piece = text[i];
    if (line.size() + piece.size() > most) return line + "...";
    line += piece;
    i += std::max<size_t>(control, 1);
  }
  return line;
}

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

void FailedCallLog::Note(const std::string& rpc, const absl::Status& status) {
  MutexLock lock(&mutex_);
  if (!TakeTurn()) {
    ++left_out_;
    return;
  }
  std::string line = absl::StrCat(rpc, ": ", absl::StatusCodeToString(status.code()), ": ",
                                  LineOf(std::string(status.message()), kMaxLine));
  if (left_out_ > 0) absl::StrAppend(&line, " (", left_out_, " more failed calls before it)");
  left_out_ = 0;
  write_(status, line);
}

}  // namespace isthmus::server
