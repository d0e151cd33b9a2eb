#include "client/console/console.h"

#include <absl/strings/str_format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

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
  absl::FPrintF(stderr, "%s: %d of %d\n", what_, done, total_);
}

void Progress::Draw() {
  drawn_ = true;
  if (total_ == 0) {
    absl::FPrintF(stderr, "\r%s: %d ", what_, done_);
  } else {
    constexpr int kWidth = 30;
    const int filled = static_cast<int>(done_ * kWidth / total_);
    absl::FPrintF(stderr, "\r%s [%s%s] %d/%d ", what_, std::string(filled, '='),
                  std::string(kWidth - filled, ' '), done_, total_);
  }
  std::fflush(stderr);
}

std::string HumanBytes(uint64_t bytes) {
  const double size = static_cast<double>(bytes);
  if (bytes >= 1'000'000'000) return absl::StrFormat("%.1f GB", size / 1e9);
  if (bytes >= 1'000'000) return absl::StrFormat("%.1f MB", size / 1e6);
  if (bytes >= 1'000) return absl::StrFormat("%.0f kB", size / 1e3);
  return absl::StrFormat("%d bytes", bytes);
}

}  // namespace isthmus::cli
