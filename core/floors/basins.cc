#include "core/floors/basins.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/floors/limits.h"

namespace isthmus::floors {
namespace {

constexpr double kStepsPerCell = 8;  // Math: distances are put in order to an eighth of a cell.

// Open cells, the farthest from walls first. A counting sort.
std::vector<uint32_t> InOrder(const std::vector<int32_t>& squares) {
  const auto step = [](int32_t square) {
    return static_cast<size_t>(kStepsPerCell * std::sqrt(static_cast<double>(square)));
  };
  int32_t most = 0;
  for (const int32_t square : squares) most = std::max(most, square);
  std::vector<size_t> begins(step(most) + 2);
  for (const int32_t square : squares) ++begins[step(most) - step(square) + 1];
  for (size_t i = 1; i < begins.size(); ++i) begins[i] += begins[i - 1];
  std::vector<uint32_t> cells(squares.size());
  for (size_t i = 0; i < squares.size(); ++i) {
    cells[begins[step(most) - step(squares[i])]++] = static_cast<uint32_t>(i);
  }
  while (!cells.empty() && squares[cells.back()] == 0) cells.pop_back();
  return cells;
}

class Flood {
 public:
  Flood(const Mask& mask, const std::vector<int32_t>& squares)
      : mask_(mask), squares_(squares), labels_(squares.size(), -1) {}

  // Takes the next cell: into the basin whose neighbouring cell is the farthest from walls.
  void Take(size_t cell) {
    const Cell at = mask_.At(cell);
    std::array<int32_t, 4> met = {};
    size_t count = 0;
    int32_t best = -1, best_square = -1;
    for (const auto& [x, y] :
         {Cell{at.x - 1, at.y}, Cell{at.x + 1, at.y}, Cell{at.x, at.y - 1}, Cell{at.x, at.y + 1}}) {
      if (!mask_.Has(x, y) || labels_[mask_.Index(x, y)] < 0) continue;
      met[count] = Root(labels_[mask_.Index(x, y)]);
      if (squares_[mask_.Index(x, y)] > best_square) {
        best_square = squares_[mask_.Index(x, y)];
        best = met[count];
      }
      ++count;
    }
    labels_[cell] = best < 0 ? Begin(cell) : best;
    for (size_t i = 0; i < count; ++i) {
      if (met[i] != best) Meet(met[i], best, cell);
    }
  }

  // Numbers the basins by their first cells.
  Basins Finish() {
    Basins basins{std::move(labels_), {}};
    std::vector<int32_t> numbers(parents_.size(), -1);
    for (int32_t& label : basins.labels) {
      if (label < 0) continue;
      const int32_t root = Root(label);
      int32_t& number = numbers[static_cast<size_t>(root)];
      if (number < 0) {
        number = static_cast<int32_t>(basins.peaks.size());
        basins.peaks.push_back(peaks_[static_cast<size_t>(root)]);
      }
      label = number;
    }
    return basins;
  }

 private:
  int32_t Root(int32_t label) {
    while (parents_[static_cast<size_t>(label)] != label) {
      int32_t& parent = parents_[static_cast<size_t>(label)];
      parent = parents_[static_cast<size_t>(parent)];
      label = parent;
    }
    return label;
  }

  int32_t Begin(size_t peak) {
    parents_.push_back(static_cast<int32_t>(peaks_.size()));
    peaks_.push_back(peak);
    return parents_.back();
  }

  double Square(int32_t root) const { return squares_[peaks_[static_cast<size_t>(root)]]; }

  // Two basins meet at a cell, the widest place between them.
  void Meet(int32_t a, int32_t b, size_t cell) {
    a = Root(a), b = Root(b);
    if (Square(a) < Square(b)) std::swap(a, b);
    if (squares_[cell] < kNeckShare * kNeckShare * Square(b)) return;
    parents_[static_cast<size_t>(b)] = a;
  }

  const Mask& mask_;
  const std::vector<int32_t>& squares_;
  std::vector<int32_t> labels_, parents_;
  std::vector<size_t> peaks_;
};

}  // namespace

Basins FindBasins(const Mask& mask, const std::vector<int32_t>& squares) {
  Flood flood(mask, squares);
  for (const uint32_t cell : InOrder(squares)) flood.Take(cell);
  return flood.Finish();
}

}  // namespace isthmus::floors
