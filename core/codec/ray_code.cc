#include "core/codec/ray_code.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "core/codec/bit_stream.h"

// Compiled with -ffp-contract=off (CMakeLists.txt): a fused multiplication rounds differently.

namespace isthmus::codec {
namespace {

// Symbols of the distance: folded differences below kFirstEscape stand for themselves; from there
// on the symbol tells how many bits of it follow among the escapes.
constexpr uint32_t kFirstEscape = 208;
constexpr uint32_t kEscapeBits = 7;  // Symbol kFirstEscape + i: a number of 7 + i + 1 bits.
constexpr uint8_t kZeroPoint = 254;  // x = y = z = 0, as some drivers write no-returns.
constexpr uint8_t kNoReturn = 255;
// The other two share a symbol; 15 stands for more, which follows among the escapes.
constexpr uint32_t kNibble = 15;

constexpr double kLimit = 1073741824.0;  // 2^30: predictions stay within 31 bits.
constexpr double kMaxTurns = 1e6;        // More, or not a number, counts as none.
constexpr double kEdge = 64;             // Steps; a larger difference begins another surface.
constexpr double kNear = 250;            // Steps; nearer points do not tell directions.
constexpr size_t kBlock = 256;

uint32_t Fold(int32_t value) {
  return (static_cast<uint32_t>(value) << 1) ^ static_cast<uint32_t>(value >> 31);
}
int32_t Unfold(uint32_t folded) {
  return static_cast<int32_t>((folded >> 1) ^ (~(folded & 1) + 1));
}

int32_t Round(double value) {
  value = value < kLimit ? value : kLimit;  // Not a number becomes the limit.
  value = value > -kLimit ? value : -kLimit;
  return static_cast<int32_t>(value + (value < 0 ? -0.5 : 0.5));
}

int32_t Subtract(int32_t a, int32_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) - static_cast<uint32_t>(b));
}
int32_t Add(int32_t a, int32_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b));
}

// Cosines and sines of angles in turns. No branches, so that compilers take several at once.
void CosSin(const double* turns, size_t n, double* cosines, double* sines) {
  for (size_t i = 0; i < n; ++i) {
    const double quarters = turns[i] * 4;
    const auto quarter = static_cast<int32_t>(quarters + (quarters < 0 ? -0.5 : 0.5));
    const double a = (quarters - quarter) * 1.5707963267948966;  // Within pi / 4.
    const double a2 = a * a;
    const double s =
        a * (1 + a2 * (-1.0 / 6 + a2 * (1.0 / 120 + a2 * (-1.0 / 5040 + a2 * (1.0 / 362880)))));
    const double c =
        1 + a2 * (-0.5 + a2 * (1.0 / 24 + a2 * (-1.0 / 720 + a2 * (1.0 / 40320))));
    const double main = (quarter & 1) != 0 ? s : c, other = (quarter & 1) != 0 ? c : s;
    cosines[i] = (((quarter + 1) & 2) != 0) ? -main : main;
    sines[i] = ((quarter & 2) != 0) ? -other : other;
  }
}

// What is known of a ring's next point.
struct RingState {
  double turn, slope, side, height;
  double distance = 0, speed = 0;  // Predicted, and by how much it changes from point to point.
  double bend = 0;                 // Radians that azimuths are beside the model.
};

// The predictions for one point after the other. A step is: Predict*, then Learn.
class RayCoder {
 public:
  explicit RayCoder(const RayModel& model)
      : turns_per_unit_(model.turns_per_unit),
        follow_distance_(model.gains.distance / 256.0),
        follow_speed_(model.gains.speed / 256.0),
        follow_azimuth_(model.gains.azimuth / 256.0),
        follow_slope_(model.gains.slope / 256.0) {
    for (const RingModel& ring : model.rings) {
      rings_.push_back({ring.turn, ring.slope, ring.side, ring.height});
    }
  }

  // Points from `first` on, at most kBlock, are next.
  void Begin(const RayPoints& points, size_t first, size_t n) {
    double turns[kBlock];
    for (size_t i = 0; i < n; ++i) {
      const double turn =
          rings_[points.ring[first + i]].turn + turns_per_unit_ * points.time[first + i];
      turns[i] = std::abs(turn) < kMaxTurns ? turn : 0;
    }
    CosSin(turns, n, cosines_, sines_);
  }

  // The i-th of the block.
  void Aim(size_t i, uint16_t ring) {
    ring_ = &rings_[ring];
    const double c = cosines_[i] - ring_->bend * sines_[i];
    const double s = sines_[i] + ring_->bend * cosines_[i];
    x_is_main_ = std::abs(cosines_[i]) >= std::abs(sines_[i]);
    main_ = x_is_main_ ? c : s;
    other_ = x_is_main_ ? s : c;
    side_main_ = x_is_main_ ? -ring_->side * s : ring_->side * c;
    side_other_ = x_is_main_ ? ring_->side * c : -ring_->side * s;
    inverse_ = 1 / main_;
  }

  bool x_is_main() const { return x_is_main_; }
  bool backwards() const { return main_ < 0; }
  // The coordinate of x and y along which the ray runs more.
  int32_t PredictMain() const { return Round(ring_->distance * main_ + side_main_); }
  // The other two, once that is known.
  void PredictAcross(int32_t main, int32_t* other, int32_t* z) {
    rho_ = (main - side_main_) * inverse_;
    exact_other_ = rho_ * other_ + side_other_;
    exact_z_ = rho_ * ring_->slope + ring_->height;
    *other = Round(exact_other_);
    *z = Round(exact_z_);
  }

  void Learn(int32_t other, int32_t z) {
    RingState& ring = *ring_;
    const double change = rho_ - ring.distance;
    if (std::abs(change) < kEdge) {
      ring.speed += follow_speed_ * change;
      ring.distance += follow_distance_ * change + ring.speed;
    } else {
      ring.speed = 0;
      ring.distance = rho_;
    }
    const double off = other - exact_other_, off_z = z - exact_z_;
    if (rho_ > kNear && std::abs(off) < kEdge && std::abs(off_z) < kEdge) {
      const double per_step = 1 / rho_;
      ring.bend += follow_azimuth_ * (x_is_main_ ? off : -off) * main_ * per_step;
      ring.slope += follow_slope_ * off_z * per_step;
    }
  }

 private:
  const double turns_per_unit_;
  const double follow_distance_, follow_speed_, follow_azimuth_, follow_slope_;
  std::vector<RingState> rings_;
  double cosines_[kBlock], sines_[kBlock];

  RingState* ring_ = nullptr;
  bool x_is_main_ = true;
  double main_ = 1, other_ = 0, side_main_ = 0, side_other_ = 0, inverse_ = 1;
  double rho_ = 0, exact_other_ = 0, exact_z_ = 0;
};

void WriteRest(uint32_t rest, BitWriter& bits) {
  const int width = std::bit_width(rest);
  bits.Write(static_cast<uint32_t>(width), 6);
  if (width > 1) bits.Write(rest ^ (1u << (width - 1)), width - 1);
}

uint32_t ReadRest(BitReader& bits) {
  const auto width = static_cast<int>(bits.Read(6));
  if (width == 0 || width > 32) return 0;
  return (1u << (width - 1)) | bits.Read(width - 1);
}

char EncodeDistance(uint32_t folded, BitWriter& bits) {
  if (folded < kFirstEscape) return static_cast<char>(folded);
  const int width = std::bit_width(folded);  // 8 to 32.
  bits.Write(folded ^ (1u << (width - 1)), width - 1);
  return static_cast<char>(kFirstEscape + static_cast<uint32_t>(width) - kEscapeBits - 1);
}

// False for a symbol that stands for nothing.
bool DecodeDistance(uint8_t symbol, BitReader& bits, uint32_t* folded) {
  *folded = symbol;
  if (symbol < kFirstEscape) return true;
  const auto width = static_cast<int>(symbol - kFirstEscape + kEscapeBits + 1);
  if (width > 32) return false;
  *folded = (1u << (width - 1)) | bits.Read(width - 1);
  return true;
}

char EncodeAcross(uint32_t other, uint32_t z, BitWriter& bits) {
  if (other >= kNibble) WriteRest(other - kNibble, bits);
  if (z >= kNibble) WriteRest(z - kNibble, bits);
  return static_cast<char>(std::min(other, kNibble) << 4 | std::min(z, kNibble));
}

void DecodeAcross(uint8_t symbol, BitReader& bits, uint32_t* other, uint32_t* z) {
  *other = symbol >> 4;
  *z = symbol & 15;
  if (*other == kNibble) *other += ReadRest(bits);
  if (*z == kNibble) *z += ReadRest(bits);
}

}  // namespace

RaySymbols EncodeRays(const RayModel& model, const RayPoints& points) {
  RaySymbols symbols;
  const size_t n = points.x.size();
  symbols.distance.resize(n);
  symbols.across.resize(n);
  BitWriter bits;
  RayCoder coder(model);
  for (size_t first = 0; first < n; first += kBlock) {
    const size_t count = std::min(kBlock, n - first);
    coder.Begin(points, first, count);
    for (size_t i = first; i < first + count; ++i) {
      const int32_t x = points.x[i], y = points.y[i], z = points.z[i];
      if (points.is_return[i] == 0 || (x | y | z) == 0) {
        symbols.distance[i] =
            static_cast<char>(points.is_return[i] == 0 ? kNoReturn : kZeroPoint);
        continue;
      }
      coder.Aim(i - first, points.ring[i]);
      const int32_t main = coder.x_is_main() ? x : y, other = coder.x_is_main() ? y : x;
      int32_t change = Subtract(main, coder.PredictMain());
      if (coder.backwards()) change = Subtract(0, change);
      symbols.distance[i] = EncodeDistance(Fold(change), bits);
      int32_t predicted_other = 0, predicted_z = 0;
      coder.PredictAcross(main, &predicted_other, &predicted_z);
      symbols.across[i] = EncodeAcross(Fold(Subtract(other, predicted_other)),
                                       Fold(Subtract(z, predicted_z)), bits);
      coder.Learn(other, z);
    }
  }
  symbols.escapes = bits.Finish();
  return symbols;
}

bool DecodeRays(const RayModel& model, const char* distance, const char* across,
                const char* escapes, size_t escape_bytes, RayPoints& points) {
  const size_t n = points.ring.size();
  points.x.assign(n, 0);
  points.y.assign(n, 0);
  points.z.assign(n, 0);
  points.is_return.assign(n, 1);
  BitReader bits(escapes, escape_bytes);
  RayCoder coder(model);
  for (size_t first = 0; first < n; first += kBlock) {
    const size_t count = std::min(kBlock, n - first);
    coder.Begin(points, first, count);
    for (size_t i = first; i < first + count; ++i) {
      const auto symbol = static_cast<uint8_t>(distance[i]);
      if (symbol >= kZeroPoint) {
        points.is_return[i] = symbol == kZeroPoint;
        continue;
      }
      uint32_t folded = 0;
      if (!DecodeDistance(symbol, bits, &folded)) return false;
      coder.Aim(i - first, points.ring[i]);
      int32_t change = Unfold(folded);
      if (coder.backwards()) change = Subtract(0, change);
      const int32_t main = Add(coder.PredictMain(), change);
      int32_t other = 0, z = 0;
      coder.PredictAcross(main, &other, &z);
      uint32_t folded_other = 0, folded_z = 0;
      DecodeAcross(static_cast<uint8_t>(across[i]), bits, &folded_other, &folded_z);
      other = Add(other, Unfold(folded_other));
      z = Add(z, Unfold(folded_z));
      coder.Learn(other, z);
      (coder.x_is_main() ? points.x : points.y)[i] = main;
      (coder.x_is_main() ? points.y : points.x)[i] = other;
      points.z[i] = z;
    }
  }
  return bits.complete();
}

}  // namespace isthmus::codec
