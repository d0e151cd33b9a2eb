// Wall time of a stage.
#pragma once

#include <chrono>

namespace isthmus {

class Stopwatch {
 public:
  Stopwatch() : start_(std::chrono::steady_clock::now()) {}
  double Ms() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_)
        .count();
  }
  // Milliseconds since construction or the last Lap.
  double Lap() {
    const double ms = Ms();
    start_ = std::chrono::steady_clock::now();
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point start_;
};

}  // namespace isthmus
