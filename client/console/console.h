// Progress for a person to watch: a progress bar on a terminal, plain lines in a pipe.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace isthmus::cli {

// Written to stderr, so that stdout stays what was asked for. On a terminal a bar as wide as that,
// which redraws itself at most ten times a second, with the rate and the time left; else a line at
// every tenth part. Not thread safe.
class Progress {
 public:
  // `total` 0: unknown, only the count and the rate are shown.
  Progress(std::string what, uint64_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Update(uint64_t done);

 private:
  void Draw();

  const std::string what_;
  const uint64_t total_;
  const bool terminal_;
  uint64_t done_ = 0, shown_tenths_ = 0;
  bool drawn_ = false;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_;
};

// A line of a progress bar of that many columns: "scans [====    ] 40/80  98/s  0:04 left"; without
// the bar where the terminal is narrow. `total` 0: unknown.
std::string ProgressLine(const std::string& what, uint64_t done, uint64_t total, double seconds,
                         size_t columns);

// "12.3 MB", "950 kB".
std::string HumanBytes(uint64_t bytes);

}  // namespace isthmus::cli
