#include "core/floors/distance.h"

#include <algorithm>

namespace isthmus::floors {
namespace {

constexpr int32_t kFarCells = 30000;  // Math: cells; its square fits.

// Cells up or down to the nearest that is not open.
std::vector<int32_t> ColumnDistances(const Mask& mask) {
  std::vector<int32_t> distances(mask.open.size());
  const int32_t beyond = mask.is_open_beyond ? kFarCells : 0;
  const auto pass = [&](int64_t y, int64_t before) {
    for (int64_t x = 0; x < mask.width; ++x) {
      const size_t at = mask.Index(x, y);
      const int32_t last = mask.Has(x, before) ? distances[mask.Index(x, before)] : beyond;
      const int32_t next = mask.open[at] == 0 ? 0 : std::min(last + 1, kFarCells);
      distances[at] = before < y ? next : std::min(distances[at], next);
    }
  };
  for (int64_t y = 0; y < mask.height; ++y) pass(y, y - 1);
  for (int64_t y = mask.height; y-- > 0;) pass(y, y + 1);
  return distances;
}

// The lower envelope of one parabola per cell of a row, and one beyond each end.
class Envelope {
 public:
  Envelope(int64_t width, int32_t beyond) : width_(width), beyond_(beyond) {
    places_.resize(static_cast<size_t>(width) + 2);
    heights_ = starts_ = places_;
  }

  // `row`: distances along columns, which become squares of distances.
  void Lower(int32_t* row) {
    count_ = 0;
    for (int64_t x = -1; x <= width_; ++x) {
      const int64_t column = x < 0 || x == width_ ? beyond_ : row[x];
      Add(x, column * column);
    }
    size_t at = 0;
    for (int64_t x = 0; x < width_; ++x) {
      while (at + 1 < count_ && starts_[at + 1] <= x) ++at;
      const int64_t off = x - places_[at];
      row[x] =
          static_cast<int32_t>(std::min<int64_t>(off * off + heights_[at], kFarCells * kFarCells));
    }
  }

 private:
  void Add(int64_t x, int64_t height) {
    int64_t start = -1;
    while (count_ > 0) {
      const size_t top = count_ - 1;
      // The first cell at which the new parabola is not above the last.
      const int64_t rise = height + x * x - heights_[top] - places_[top] * places_[top];
      const int64_t run = 2 * (x - places_[top]);
      start = rise >= 0 ? (rise + run - 1) / run : -(-rise / run);
      if (start > starts_[top]) break;
      --count_;
    }
    if (count_ == 0) start = -1;
    places_[count_] = x;
    heights_[count_] = height;
    starts_[count_++] = start;
  }

  int64_t width_;
  int32_t beyond_;
  size_t count_ = 0;
  std::vector<int64_t> places_, heights_, starts_;
};

}  // namespace

std::vector<int32_t> SquaredDistances(const Mask& mask) {
  std::vector<int32_t> distances = ColumnDistances(mask);
  Envelope envelope(mask.width, mask.is_open_beyond ? kFarCells : 0);
  for (int64_t y = 0; y < mask.height; ++y) envelope.Lower(distances.data() + y * mask.width);
  return distances;
}

}  // namespace isthmus::floors
