// Pseudo-random numbers that are the same on every machine and library.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace isthmus::simulation {

// SplitMix64 (Steele, Lea, Flood, "Fast splittable pseudorandom number generators", 2014). The
// standard library's distributions differ between implementations; these do not. Value type; not
// thread safe.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}
  // An independent stream for every pair of numbers, e.g. a robot and a scan.
  Random(uint64_t seed, uint64_t a, uint64_t b) : state_(seed) {
    state_ = Next() ^ (a * 0x9E3779B97F4A7C15u);
    state_ = Next() ^ (b * 0xC2B2AE3D27D4EB4Fu);
  }

  uint64_t Next() {
    uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  // In [0, 1).
  double Unit() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Unit(); }
  // In [0, count); count > 0.
  int Index(int count) { return static_cast<int>(Unit() * count); }
  bool Chance(double probability) { return Unit() < probability; }
  // Standard normal (Box-Muller; the second of the pair is kept for the next call).
  double Normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2 * std::log(1 - Unit()));
    const double angle = 2 * std::numbers::pi * Unit();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

 private:
  uint64_t state_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace isthmus::simulation
