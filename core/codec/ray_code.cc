#include "core/codec/ray_code.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <vector>

#include "core/codec/bit_stream.h"

// Compiled with -ffp-contract=off (CMakeLists.txt): a fused multiplication rounds differently.

// Compiled twice, the processor decides: four numbers at a time instead of two, to the same bits.
// Not with sanitizers, which such a choice at the start of the program upsets.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define ISTHMUS_RAY_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define ISTHMUS_RAY_CLONES
#endif

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

uint32_t Fold(int32_t value) {
  return (static_cast<uint32_t>(value) << 1) ^ static_cast<uint32_t>(value >> 31);
}
int32_t Unfold(uint32_t folded) {
  return static_cast<int32_t>((folded >> 1) ^ (~(folded & 1) + 1));
}

int32_t Round(double value) {
  value = value < kLimit ? value : kLimit;  // Not a number becomes the limit.
  value = value > -kLimit ? value : -kLimit;
  return static_cast<int32_t>(value + std::copysign(0.5, value));  // No branch.
}

int32_t Subtract(int32_t a, int32_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) - static_cast<uint32_t>(b));
}
int32_t Add(int32_t a, int32_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b));
}

// Cosines and sines of angles in turns. No branches, so that compilers take several at once.
ISTHMUS_RAY_CLONES void CosSin(const double* turns, size_t n, double* cosines, double* sines) {
  for (size_t i = 0; i < n; ++i) {
    const double quarters = turns[i] * 4;
    const auto quarter = static_cast<int32_t>(quarters + (quarters < 0 ? -0.5 : 0.5));
    const double a = (quarters - quarter) * 1.5707963267948966;  // Within pi / 4.
    const double a2 = a * a;
    const double s =
        a * (1 + a2 * (-1.0 / 6 + a2 * (1.0 / 120 + a2 * (-1.0 / 5040 + a2 * (1.0 / 362880)))));
    const double c = 1 + a2 * (-0.5 + a2 * (1.0 / 24 + a2 * (-1.0 / 720 + a2 * (1.0 / 40320))));
    const double main = (quarter & 1) != 0 ? s : c, other = (quarter & 1) != 0 ? c : s;
    cosines[i] = (((quarter + 1) & 2) != 0) ? -main : main;
    sines[i] = ((quarter & 2) != 0) ? -other : other;
  }
}

// The state that predicts a ring's next point.
struct RingState {
  double turn, slope, side, height;
  double distance = 0, speed = 0;  // Predicted, and by how much it changes from point to point.
  double bend = 0;                 // Radians that azimuths are beside the model.
};

// The expected place of a point along x and y; `main` is the one that the ray runs along more.
struct Ray {
  RingState* ring;
  bool x_is_main;
  double main, other, side_main, side_other;

  bool backwards() const { return main < 0; }
  int32_t PredictMain() const { return Round(ring->distance * main + side_main); }
};

// The ray's point at a known main coordinate.
struct Passing {
  Passing(const Ray& ray, int32_t at)
      : rho((at - ray.side_main) / ray.main),
        other(Round(rho * ray.other + ray.side_other)),
        z(Round(rho * ray.ring->slope + ray.ring->height)) {}

  double rho;
  int32_t other, z;
};

// The predictions for one point after the other: Aim, PredictMain, Passing, Learn.
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

  // Points from `first` on, at most kRayBlock, are next.
  void Begin(const RayPoints& points, size_t first, size_t n) {
    double turns[kRayBlock];
    for (size_t i = 0; i < n; ++i) {
      const double turn =
          rings_[points.ring[first + i]].turn + turns_per_unit_ * points.time[first + i];
      turns[i] = std::abs(turn) < kMaxTurns ? turn : 0;
    }
    CosSin(turns, n, cosines_, sines_);
  }

  // The ray of a point that is the k-th of the block.
  Ray Aim(size_t k, uint16_t ring) {
    RingState& state = rings_[ring];
    const double c = cosines_[k] - state.bend * sines_[k];
    const double s = sines_[k] + state.bend * cosines_[k];
    Ray ray;
    ray.ring = &state;
    ray.x_is_main = std::abs(cosines_[k]) >= std::abs(sines_[k]);
    ray.main = ray.x_is_main ? c : s;
    ray.other = ray.x_is_main ? s : c;
    ray.side_main = ray.x_is_main ? -state.side * s : state.side * c;
    ray.side_other = ray.x_is_main ? state.side * c : -state.side * s;
    return ray;
  }

  void Learn(const Ray& ray, const Passing& at, int32_t off, int32_t off_z) const {
    RingState& ring = *ray.ring;
    const double change = at.rho - ring.distance;
    if (std::abs(change) < kEdge) {
      ring.speed += follow_speed_ * change;
      ring.distance += follow_distance_ * change + ring.speed;
    } else {
      ring.speed = 0;
      ring.distance = at.rho;
    }
    if ((off | off_z) == 0) return;  // Most; what is rounded off teaches nothing.
    const double aside = ray.x_is_main ? off : -static_cast<double>(off);
    if (at.rho > kNear && std::abs(aside) < kEdge && std::abs(off_z) < kEdge) {
      const double per_step = 1 / at.rho;
      ring.bend += follow_azimuth_ * aside * ray.main * per_step;
      ring.slope += follow_slope_ * off_z * per_step;
    }
  }

 private:
  const double turns_per_unit_;
  const double follow_distance_, follow_speed_, follow_azimuth_, follow_slope_;
  std::vector<RingState> rings_;
  double cosines_[kRayBlock], sines_[kRayBlock];
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

ISTHMUS_RAY_CLONES RaySymbols EncodeRays(const RayModel& model, const RayPoints& points) {
  RaySymbols symbols;
  const size_t n = points.x.size();
  symbols.distance.reserve(n);
  symbols.across.reserve(n);
  BitWriter bits;
  RayCoder coder(model);
  for (size_t first = 0; first < n; first += kRayBlock) {
    const size_t count = std::min(kRayBlock, n - first);
    coder.Begin(points, first, count);
    // Written here first: compilers take into account that a char* may point to anything.
    char distance[kRayBlock], across[kRayBlock];
    for (size_t k = 0; k < count; ++k) {
      const size_t i = first + k;
      const int32_t x = points.x[i], y = points.y[i], z = points.z[i];
      if (points.is_return[i] == 0 || (x | y | z) == 0) {
        distance[k] = static_cast<char>(points.is_return[i] == 0 ? kNoReturn : kZeroPoint);
        across[k] = 0;
        continue;
      }
      const Ray ray = coder.Aim(k, points.ring[i]);
      const int32_t main = ray.x_is_main ? x : y, other = ray.x_is_main ? y : x;
      int32_t change = Subtract(main, ray.PredictMain());
      if (ray.backwards()) change = Subtract(0, change);
      distance[k] = EncodeDistance(Fold(change), bits);
      const Passing at(ray, main);
      const int32_t off = Subtract(other, at.other), off_z = Subtract(z, at.z);
      across[k] = EncodeAcross(Fold(off), Fold(off_z), bits);
      coder.Learn(ray, at, off, off_z);
    }
    symbols.distance.append(distance, count);
    symbols.across.append(across, count);
  }
  symbols.escapes = bits.Finish();
  return symbols;
}

struct RayDecoder::State {
  State(const RayModel& model, const RayStreams& from)
      : streams(from), bits(from.escapes, from.escape_bytes), coder(model) {}

  RayStreams streams;
  BitReader bits;
  RayCoder coder;
};

RayDecoder::RayDecoder(const RayModel& model, const RayStreams& streams)
    : state_(std::make_unique<State>(model, streams)) {}

RayDecoder::~RayDecoder() = default;

ISTHMUS_RAY_CLONES bool RayDecoder::Next(RayPoints& points) {
  BitReader bits = state_->bits;  // Copied: it then stays in registers.
  RayCoder& coder = state_->coder;
  const size_t n = points.ring.size();
  points.x.resize(n);
  points.y.resize(n);
  points.z.resize(n);
  points.is_return.resize(n);
  coder.Begin(points, 0, n);
  for (size_t i = 0; i < n; ++i) {
    const auto symbol = static_cast<uint8_t>(*state_->streams.distance++);
    const auto across = static_cast<uint8_t>(*state_->streams.across++);
    points.is_return[i] = symbol != kNoReturn;
    if (symbol >= kZeroPoint) {
      points.x[i] = points.y[i] = points.z[i] = 0;
      continue;
    }
    uint32_t folded = 0;
    if (!DecodeDistance(symbol, bits, &folded)) return false;
    const Ray ray = coder.Aim(i, points.ring[i]);
    int32_t change = Unfold(folded);
    if (ray.backwards()) change = Subtract(0, change);
    const int32_t main = Add(ray.PredictMain(), change);
    const Passing at(ray, main);
    uint32_t folded_other = 0, folded_z = 0;
    DecodeAcross(across, bits, &folded_other, &folded_z);
    const int32_t off = Unfold(folded_other), off_z = Unfold(folded_z);
    coder.Learn(ray, at, off, off_z);
    const int32_t other = Add(at.other, off);
    points.x[i] = ray.x_is_main ? main : other;
    points.y[i] = ray.x_is_main ? other : main;
    points.z[i] = Add(at.z, off_z);
  }
  state_->bits = bits;
  return true;
}

bool RayDecoder::complete() const { return state_->bits.complete(); }

}  // namespace isthmus::codec
