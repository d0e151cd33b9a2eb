// The work that a scan takes, counted in steps and not in time, so that results do not depend on
// how fast a machine is.
#pragma once

#include <cstdint>
#include <limits>

namespace isthmus::floam {

// One step is a point, a neighbour of one or a feature that is looked at: some 5 to 50 ns. Code
// that may take far more of them than there are points counts them, and stops once too many were
// spent. Not thread safe.
class Work {
 public:
  // The uses of steps.
  enum class Kind { kNone, kNeighbours, kRings, kScanToScan, kMap };

  explicit Work(uint64_t most = std::numeric_limits<uint64_t>::max()) : most_(most) {}

  void Add(Kind kind, uint64_t steps) {
    steps_ += steps;
    if (steps_ > most_ && spent_on_ == Kind::kNone) spent_on_ = kind;
  }
  uint64_t steps() const { return steps_; }
  bool spent() const { return spent_on_ != Kind::kNone; }
  Kind spent_on() const { return spent_on_; }  // The use that went beyond; kNone: none did.

 private:
  uint64_t most_;
  uint64_t steps_ = 0;
  Kind spent_on_ = Kind::kNone;
};

}  // namespace isthmus::floam
