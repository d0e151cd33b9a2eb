#include "client/console/console.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "client/console/say.h"

namespace isthmus::cli {

Progress::Progress(std::string what, uint64_t total)
    : what_(std::move(what)), total_(total), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (!terminal_ || !drawn_) return;
  Draw();
  std::fputc('\n', stderr);
}

void Progress::Update(uint64_t done) {
  done_ = done;
  if (terminal_) {
    const auto now = std::chrono::steady_clock::now();
    if (drawn_ && now - last_ < std::chrono::milliseconds(100) && done != total_) return;
    last_ = now;
    Draw();
    return;
  }
  if (total_ == 0) return;
  const uint64_t tenths = done * 10 / total_;
  if (tenths == shown_tenths_) return;
  shown_tenths_ = tenths;
  Warn("%s: %d of %d\n", what_, done, total_);
}

void Progress::Draw() {
  drawn_ = true;
  winsize size{};
  const bool is_known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
  // The rest of the line before may be longer: it is erased.
  Warn("\r%s\x1b[K",
       ProgressLine(what_, done_, total_, passed.count(), is_known ? size.ws_col : 80));
  std::fflush(stderr);
}

std::string ProgressLine(const std::string& what, uint64_t done, uint64_t total, double seconds,
                         size_t columns) {
  const double rate = seconds > 0 ? static_cast<double>(done) / seconds : 0;
  std::string numbers = total == 0 ? absl::StrFormat(" %d  %.0f/s", done, rate)
                                   : absl::StrFormat(" %d/%d  %.0f/s", done, total, rate);
  if (total > done && rate > 0) {
    const auto left = static_cast<int64_t>(static_cast<double>(total - done) / rate + 0.5);
    absl::StrAppendFormat(&numbers, "  %d:%02d left", left / 60, left % 60);
  }
  // A column is left free: a full line would wrap.
  constexpr size_t kFrame = 4, kLeastBar = 10, kWidestBar = 60;
  const size_t taken = what.size() + numbers.size() + kFrame;
  if (total == 0 || taken + kLeastBar > columns) return (what + numbers).substr(0, columns - 1);
  const size_t width = std::min(columns - taken, kWidestBar);
  const size_t filled = width * std::min(done, total) / total;
  return absl::StrCat(what, " [", std::string(filled, '='), std::string(width - filled, ' '), "]",
                      numbers);
}

std::string HumanBytes(uint64_t bytes) {
  const double size = static_cast<double>(bytes);
  if (bytes >= 1'000'000'000) return absl::StrFormat("%.1f GB", size / 1e9);
  if (bytes >= 1'000'000) return absl::StrFormat("%.1f MB", size / 1e6);
  if (bytes >= 1'000) return absl::StrFormat("%.0f kB", size / 1e3);
  return absl::StrFormat("%d bytes", bytes);
}

}  // namespace isthmus::cli
