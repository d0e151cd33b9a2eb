#include "server/composition/tiles/detail_order.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace isthmus::composition {
namespace {

// Bits per axis of the curve within a voxel of the coarsest level.
constexpr int kCurveBits = kDetailLevels - 1;          // Layout
constexpr int32_t kCurveMask = (1 << kCurveBits) - 1;  // Layout
// Bits of a digit to sort by, and number of voxels below which they are sorted without digits:
// clearing the counters of all digits would cost more.
constexpr int kDigitBits = 10;       // Layout
constexpr size_t kFewVoxels = 1024;  // Layout

// Bit i of the index goes to bit 3 i.
constexpr std::array<uint32_t, 1 << kCurveBits> SpreadBits() {
  std::array<uint32_t, 1 << kCurveBits> spread = {};
  for (uint32_t i = 0; i < spread.size(); ++i) {
    for (int bit = 0; bit < kCurveBits; ++bit) spread[i] |= (i >> bit & 1) << 3 * bit;
  }
  return spread;
}
constexpr auto kSpread = SpreadBits();  // Math

// The Z-order curve within a voxel of the coarsest level.
uint64_t CurveWithin(const Voxel& v) {
  return kSpread[v.x & kCurveMask] << 2 | kSpread[v.y & kCurveMask] << 1 |
         kSpread[v.z & kCurveMask];
}

}  // namespace

// Coarsest voxels in order of x, y, z, counted from the lowest, so that codes have few bits;
// shifting a negative index rounds down, as a coarse voxel's must.
void DetailOrder::FindCodes(const std::vector<Voxel>& voxels) {
  constexpr int32_t kMax = std::numeric_limits<int32_t>::max();
  Voxel low{kMax, kMax, kMax}, high{-kMax, -kMax, -kMax};
  for (const Voxel& v : voxels) {
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
  }
  const auto coarse = [](int32_t index) { return index >> kCurveBits; };
  const auto bits = [&](int32_t from, int32_t to) {
    return std::bit_width(static_cast<uint32_t>(coarse(to) - coarse(from)));
  };
  const int z_bits = bits(low.z, high.z), y_bits = bits(low.y, high.y);
  entries_.resize(voxels.size());
  all_bits_ = 0;
  for (uint32_t i = 0; i < voxels.size(); ++i) {
    const Voxel& v = voxels[i];
    const auto from = [&](int32_t index, int32_t lowest) {
      return static_cast<uint64_t>(coarse(index) - coarse(lowest));
    };
    const uint64_t coarsest =
        (from(v.x, low.x) << y_bits | from(v.y, low.y)) << z_bits | from(v.z, low.z);
    entries_[i] = {coarsest << 3 * kCurveBits | CurveWithin(v), i};
    all_bits_ |= entries_[i].code;
  }
}

void DetailOrder::SortByCode() {
  if (entries_.size() < kFewVoxels) {
    std::sort(entries_.begin(), entries_.end(),
              [](const Entry& l, const Entry& r) { return l.code < r.code; });
    return;
  }
  // Digit by digit, the lowest first.
  scratch_.resize(entries_.size());
  std::array<uint32_t, 1 << kDigitBits> next;
  const auto bits = static_cast<int>(std::bit_width(all_bits_));
  for (int shift = 0; shift < bits; shift += kDigitBits) {
    const auto digit = [shift](const Entry& entry) {
      return entry.code >> shift & ((1 << kDigitBits) - 1);
    };
    next.fill(0);
    for (const Entry& entry : entries_) ++next[digit(entry)];
    uint32_t sum = 0;
    for (uint32_t& count : next) {
      const uint32_t begin = sum;
      sum += count;
      count = begin;
    }
    for (const Entry& entry : entries_) scratch_[next[digit(entry)]++] = entry;
    entries_.swap(scratch_);
  }
}

// A voxel is the first on the curve of all larger ones down to the level at which it leaves that of
// its predecessor.
void DetailOrder::OrderByLevel() {
  std::array<uint32_t, kDetailLevels> count = {};
  level_.resize(entries_.size());
  for (size_t i = 0; i < entries_.size(); ++i) {
    uint32_t level = kDetailLevels - 1;
    if (i > 0) {
      const int bits = std::bit_width(entries_[i].code ^ entries_[i - 1].code);
      level = std::min(level, static_cast<uint32_t>(std::max(bits - 1, 0)) / 3);
    }
    level_[i] = static_cast<uint8_t>(level);
    ++count[level];
  }
  std::array<uint32_t, kDetailLevels> next = {};
  uint32_t sum = 0;
  for (uint32_t level = kDetailLevels; level-- > 0;) {
    next[level] = sum;
    sum += count[level];
    level_size_[level] = sum;
  }
  order_.resize(entries_.size());
  for (size_t i = 0; i < entries_.size(); ++i) order_[next[level_[i]]++] = entries_[i].index;
}

void DetailOrder::Sort(const std::vector<Voxel>& voxels) {
  FindCodes(voxels);
  SortByCode();
  OrderByLevel();
}

}  // namespace isthmus::composition
