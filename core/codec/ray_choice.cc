#include "core/codec/ray_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "core/codec/delta_code.h"
#include "core/codec/ray_code.h"

namespace isthmus::codec {
namespace {

// Points that are coded for a try: a sixteenth, from the middle of the scan.
constexpr size_t kTryShare = 16;
constexpr size_t kLeastTry = 2048;

// Bits that a Huffman code of these bytes takes, about.
class ByteBits {
 public:
  void Add(uint8_t byte) { ++counts_[byte]; }
  double Bits() const {
    double total = 0, sum = 0;
    for (const uint32_t count : counts_) {
      if (count == 0) continue;
      total += count;
      sum += count * std::log2(static_cast<double>(count));
    }
    return total > 0 ? total * std::log2(total) - sum : 0;
  }

 private:
  std::array<uint32_t, 256> counts_ = {};
};

double BitsOf(const std::string& bytes) {
  ByteBits bits;
  for (const char byte : bytes) bits.Add(static_cast<uint8_t>(byte));
  return bits.Bits();
}

double DeltaBits(const std::vector<int32_t>& steps, const std::vector<uint8_t>& is_return) {
  DeltaEncoder encoder;
  std::array<ByteBits, 4> planes;
  for (size_t i = 0; i < steps.size(); ++i) {
    const uint32_t code = is_return[i] != 0 ? encoder.Encode(steps[i]) : kNoValueCode;
    for (size_t k = 0; k < 4; ++k) planes[k].Add(static_cast<uint8_t>(code >> (8 * k)));
  }
  return planes[0].Bits() + planes[1].Bits() + planes[2].Bits() + planes[3].Bits();
}

template <typename T>
std::vector<T> Cut(const std::vector<T>& values, size_t first, size_t n) {
  const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first);
  return {begin, begin + static_cast<std::ptrdiff_t>(n)};
}

RayPoints Stretch(const RayPoints& all) {
  const size_t n = std::min(all.x.size(), std::max(kLeastTry, all.x.size() / kTryShare));
  const size_t first = (all.x.size() - n) / 2;
  return {Cut(all.x, first, n),         Cut(all.y, first, n),    Cut(all.z, first, n),
          Cut(all.is_return, first, n), Cut(all.ring, first, n), Cut(all.time, first, n)};
}

}  // namespace

std::optional<RayModel> ChooseRays(const RayPoints& points) {
  const size_t rings = *std::max_element(points.ring.begin(), points.ring.end()) + size_t{1};
  std::optional<RayModel> model = FitRays(points, rings);
  if (!model) return model;
  const RayPoints tried = Stretch(points);
  const RaySymbols symbols = EncodeRays(*model, tried);
  const double ray_bits = BitsOf(symbols.distance) + BitsOf(symbols.across) +
                          8.0 * static_cast<double>(symbols.escapes.size());
  const double delta_bits = DeltaBits(tried.x, tried.is_return) +
                            DeltaBits(tried.y, tried.is_return) +
                            DeltaBits(tried.z, tried.is_return);
  const double share = static_cast<double>(tried.x.size()) / static_cast<double>(points.x.size());
  const double model_bits = 8.0 * static_cast<double>(sizeof(RingModel) * rings) * share;
  if (ray_bits + model_bits >= delta_bits) return std::nullopt;
  return model;
}

}  // namespace isthmus::codec
