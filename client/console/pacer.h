// The pace of a robot that is played back.
#pragma once

#include <chrono>
#include <optional>
#include <thread>

namespace isthmus::cli {

// Not thread safe.
class Pacer {
 public:
  explicit Pacer(std::optional<double> hz) : hz_(hz) {}
  // Until it is time for the next scan.
  void Wait() {
    if (!hz_) return;
    std::this_thread::sleep_until(start_ + std::chrono::duration<double>(count_++ / *hz_));
  }

 private:
  const std::optional<double> hz_;  // Absent: no pace.
  double count_ = 0;
  const std::chrono::time_point<std::chrono::steady_clock, std::chrono::duration<double>> start_ =
      std::chrono::steady_clock::now();
};

}  // namespace isthmus::cli
