#include "lab/bench/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>
#include <utility>
#include <vector>

#include "lab/bench/cpu_clock.h"

namespace isthmus::bench {
namespace {

constexpr int kPoints = 200'000;
constexpr int kQueries = 20'000;
constexpr int kNeighbours = 5;

struct CalPoint {
  float x, y, z;
};

// Marsaglia's xorshift64: nothing but a few instructions, the same everywhere.
class Sequence {
 public:
  float Unit() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return static_cast<float>(state_ >> 40) / 16777216.F;
  }
  CalPoint Place() {
    const float x = Unit() * 60, y = Unit() * 60, z = Unit() * 6;
    return {x, y, z};
  }

 private:
  uint64_t state_ = 88172645463325252U;
};

int64_t VoxelOf(const CalPoint& p) {
  const auto cell = [](float v) { return static_cast<int64_t>(std::floor(v)) + (1 << 20); };
  return cell(p.x) << 42 | cell(p.y) << 21 | cell(p.z);
}

using Symmetric = std::array<double, 6>;  // xx xy xz yy yz zz.

// In closed form: O. K. Smith, "Eigenvalues of a symmetric 3 x 3 matrix", CACM 1961.
double SmallestEigenvalue(const Symmetric& a) {
  const double q = (a[0] + a[3] + a[5]) / 3;
  const double off = a[1] * a[1] + a[2] * a[2] + a[4] * a[4];
  const double spread =
      (a[0] - q) * (a[0] - q) + (a[3] - q) * (a[3] - q) + (a[5] - q) * (a[5] - q) + 2 * off;
  const double p = std::sqrt(spread / 6) + 1e-12;
  const double b0 = (a[0] - q) / p, b3 = (a[3] - q) / p, b5 = (a[5] - q) / p;
  const double b1 = a[1] / p, b2 = a[2] / p, b4 = a[4] / p;
  const double half_determinant =
      (b0 * (b3 * b5 - b4 * b4) - b1 * (b1 * b5 - b4 * b2) + b2 * (b1 * b4 - b3 * b2)) / 2;
  const double phi = std::acos(std::clamp(half_determinant, -1.0, 1.0)) / 3;
  return q + 2 * p * std::cos(phi + 2 * std::numbers::pi / 3);
}

// Points sorted by voxel, and where each voxel's begin and end.
struct Grid {
  std::vector<CalPoint> points;
  std::unordered_map<int64_t, std::pair<int, int>> voxels;

  explicit Grid(Sequence& sequence) : points(kPoints) {
    for (CalPoint& p : points) p = sequence.Place();
    std::sort(points.begin(), points.end(),
              [](const CalPoint& a, const CalPoint& b) { return VoxelOf(a) < VoxelOf(b); });
    for (int i = 0, j = 0; i < kPoints; i = j) {
      for (j = i; j < kPoints && VoxelOf(points[j]) == VoxelOf(points[i]); ++j) {
      }
      voxels[VoxelOf(points[i])] = {i, j};
    }
  }
};

using Neighbours = std::array<std::pair<float, int>, kNeighbours>;  // Square of distance; index.

Neighbours Nearest(const Grid& grid, const CalPoint& p) {
  Neighbours best;
  best.fill({1e9F, -1});
  const auto look_in = [&](const std::pair<int, int>& range) {
    for (int i = range.first; i < range.second; ++i) {
      const CalPoint& q = grid.points[i];
      const float d =
          (q.x - p.x) * (q.x - p.x) + (q.y - p.y) * (q.y - p.y) + (q.z - p.z) * (q.z - p.z);
      if (d >= best.back().first) continue;
      int k = kNeighbours - 1;
      for (; k > 0 && best[k - 1].first > d; --k) best[k] = best[k - 1];
      best[k] = {d, i};
    }
  };
  for (float dx = -1; dx <= 1; ++dx) {
    for (float dy = -1; dy <= 1; ++dy) {
      for (float dz = -1; dz <= 1; ++dz) {
        const auto voxel = grid.voxels.find(VoxelOf({p.x + dx, p.y + dy, p.z + dz}));
        if (voxel != grid.voxels.end()) look_in(voxel->second);
      }
    }
  }
  return best;
}

Symmetric Scatter(const Grid& grid, const Neighbours& neighbours) {
  double mean[3] = {};
  for (const auto& neighbour : neighbours) {
    const CalPoint& q = grid.points[neighbour.second];
    mean[0] += q.x / kNeighbours;
    mean[1] += q.y / kNeighbours;
    mean[2] += q.z / kNeighbours;
  }
  Symmetric sum = {};
  for (const auto& neighbour : neighbours) {
    const CalPoint& q = grid.points[neighbour.second];
    const double x = q.x - mean[0], y = q.y - mean[1], z = q.z - mean[2];
    sum[0] += x * x;
    sum[1] += x * y;
    sum[2] += x * z;
    sum[3] += y * y;
    sum[4] += y * z;
    sum[5] += z * z;
  }
  return sum;
}

// CPU milliseconds of one round of the work, letting go of its memory apart.
double RoundMs(Sequence& sequence) {
  const CpuClock clock;
  const Grid grid(sequence);
  double sum = 0;
  for (int query = 0; query < kQueries; ++query) {
    const Neighbours neighbours = Nearest(grid, sequence.Place());
    if (neighbours.back().second >= 0) sum += SmallestEigenvalue(Scatter(grid, neighbours));
  }
  const double ms = clock.Ms();
  return std::isfinite(sum) ? ms : -1;  // Looked at, so that no compiler leaves the work out.
}

}  // namespace

double CalibrationMs() {
  Sequence sequence;
  std::array<double, 5> rounds;
  for (double& ms : rounds) ms = RoundMs(sequence);
  std::sort(rounds.begin(), rounds.end());
  return rounds[2];
}

}  // namespace isthmus::bench
