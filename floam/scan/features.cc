#include "floam/scan/features.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "floam/scan/limits.h"

namespace isthmus::floam {
namespace {

bool Joined(const RingPoint& a, const RingPoint& b) {
  const float dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z;
  const float gap = kSurfaceGapM + kSurfaceGapPerM * std::min(a.range, b.range);
  return dx * dx + dy * dy + dz * dz < gap * gap;  // False for NaN.
}

bool Grazing(const RingPoint& before, const RingPoint& p, const RingPoint& after) {
  const float dx = after.x - before.x, dy = after.y - before.y, dz = after.z - before.z;
  const float along = dx * p.x + dy * p.y + dz * p.z;
  const float length2 = dx * dx + dy * dy + dz * dz;
  return along * along > kGrazingCosine * kGrazingCosine * length2 * p.range * p.range;
}

// |sum over S of (p_i - p_j)| / |S| of eq. 1, squared: how far a point is from the mean of the
// others. For one point after the other, the sum goes along.
class Deviations {
 public:
  Deviations(const RingPoint* middle, int half_window) : half_window_(half_window) { Sum(middle); }

  float SquaredAt(const RingPoint* middle) {
    if (middle != middle_) {
      if (++steps_ == kStepsPerSum) {
        Sum(middle);
      } else {
        sum_ += Four(middle[half_window_]) - Four(middle_[-half_window_]);
        middle_ = middle;
      }
    }
    const auto count = static_cast<float>(2 * half_window_);
    const Eigen::Array4f off = (sum_ - Four(*middle)) / count - Four(*middle);
    return off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
  }

 private:
  static constexpr int kStepsPerSum = 16;  // Before rounding adds up.

  // Position and, for the sake of vector units, intensity.
  static Eigen::Map<const Eigen::Array4f> Four(const RingPoint& p) {
    return Eigen::Map<const Eigen::Array4f>(&p.x);
  }
  void Sum(const RingPoint* middle) {
    middle_ = middle;
    steps_ = 0;
    sum_.setZero();
    for (int j = -half_window_; j <= half_window_; ++j) sum_ += Four(middle[j]);
  }

  const int half_window_;
  const RingPoint* middle_ = nullptr;
  int steps_ = 0;
  Eigen::Array4f sum_;
};

// True if the neighbour of a point on the ring is behind it, or missing.
bool StandsOut(const RingPoint& beside, const RingPoint& p) {
  const float cosine =
      (beside.x * p.x + beside.y * p.y + beside.z * p.z) / (beside.range * p.range);
  return beside.range > p.range + kSurfaceGapM || cosine < kEmptyCosine;
}

bool MayGoAlong(const RingPoint* begin, const RingPoint* end) {
  const RingPoint& first = *begin;
  const RingPoint& middle = begin[(end - begin) / 2];  // A room's ring may end where it began.
  const RingPoint& last = end[-1];
  const auto is_far = [&](const RingPoint& p) {
    return p.range >= kOwnM ||
           (p.Position() - middle.Position()).squaredNorm() >= kOwnWidthM * kOwnWidthM / 4;
  };
  return !is_far(first) && !is_far(middle) && !is_far(last);
}

TimedPoint ToTimed(const RingPoint& p, float weight, uint16_t ring) {
  return {p.Position(), p.time, weight, ring};
}

// Normals either way, told apart by the nearest of the axes through the faces, edges and corners of
// a cube.
constexpr size_t kFacings = 13;  // Math: half of 27 - 1.

uint8_t Facing(const Eigen::Vector3f& normal) {
  static const auto* const axes = [] {
    auto* all = new std::vector<Eigen::Vector3f>;
    for (int x = 0; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          if (x == 0 && (y < 0 || (y == 0 && z <= 0))) continue;
          all->push_back(
              Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z))
                  .normalized());
        }
    return all;
  }();
  uint8_t best = 0;
  for (uint8_t k = 1; k < kFacings; ++k) {
    if (std::abs((*axes)[k].dot(normal)) > std::abs((*axes)[best].dot(normal))) best = k;
  }
  return best;
}

// Keeps `limit` of the points, evenly spread over their order.
void ThinEvenly(size_t limit, std::vector<TimedPoint>* points) {
  if (points->size() <= limit) return;
  for (size_t k = 0; k < limit; ++k) (*points)[k] = (*points)[k * points->size() / limit];
  points->resize(limit);
}

}  // namespace

float Smoothness(const RingPoint* middle, int half_window) {
  return std::sqrt(Deviations(middle, half_window).SquaredAt(middle)) / middle->range;
}

FeatureExtractor::FeatureExtractor(const FeatureOptions& options)
    : options_(options),
      surface_thinner_(options.surface_voxel_m),
      edge_thinner_(options.edge_voxel_m),
      map_thinner_(options.map_voxel_m) {}

void FeatureExtractor::SetScale(float scale) {
  scale_ = scale;
  surface_thinner_ = VoxelThinner(scale * options_.surface_voxel_m);
  map_thinner_ = VoxelThinner(scale * options_.map_voxel_m);
}

void FeatureExtractor::Extract(const RingScan& scan, Features* out) {
  const float scale = scale_;
  out->work = Work(options_.max_work);
  if (!scan.in_rings()) neighbourhoods_.Build(scan);
  ExtractAll(scan, out);
  const auto few = static_cast<size_t>(options_.few_surfaces);
  while (out->surfaces.size() < few && scale_ > kLeastVoxelScale && !out->work.spent()) {
    SetScale(0.5F * scale_);
    ExtractAll(scan, out);
  }
  // Half the voxels hold up to four times the surfaces.
  if (scale_ < 1 && out->surfaces.size() > kPlentySurfaces * few) SetScale(2 * scale_);
  if (!scan.in_rings()) Balance(&out->surfaces);
  ThinEvenly(static_cast<size_t>(options_.max_surfaces), &out->surfaces);
  ThinEvenly(static_cast<size_t>(options_.max_poles), &out->poles);
  out->chords = ChordsOf(scan, out->surfaces, &out->work);
  out->in_rings = scan.in_rings();
  if (out->work.spent() && scale != scale_) SetScale(scale);
}

void FeatureExtractor::ExtractAll(const RingScan& scan, Features* out) {
  out->edges.clear();
  out->surfaces.clear();
  out->map_surfaces.clear();
  out->poles.clear();
  surface_thinner_.Clear();
  edge_thinner_.Clear();
  map_thinner_.Clear();
  out->work.Add(Work::Kind::kRings, scan.points.size());
  if (!scan.in_rings()) return ExtractWithoutRings(scan, out);
  for (size_t ring = 0; ring + 1 < scan.ring_begin.size(); ++ring) {
    const RingPoint* begin = scan.points.data() + scan.ring_begin[ring];
    const RingPoint* end = scan.points.data() + scan.ring_begin[ring + 1];
    ring_ = static_cast<uint16_t>(ring);
    edge_candidates_.clear();
    for (const RingPoint* segment = begin; segment < end;) {
      const RingPoint* segment_end = segment + 1;
      while (segment_end < end && Joined(segment_end[-1], *segment_end)) ++segment_end;
      const bool has_sides = segment > begin && segment_end < end;
      // The surroundings of a ring's first and last points are not known.
      const bool stands_free = (segment == begin || StandsOut(segment[-1], *segment)) &&
                               (segment_end == end || StandsOut(*segment_end, segment_end[-1]));
      if (!stands_free || !MayGoAlong(segment, segment_end)) {
        ExtractSegment(segment, segment_end, out);
        if (stands_free && has_sides) AddPole(segment, segment_end, out);
      }
      segment = segment_end;
    }
    KeepBestEdges(begin, end, out);
  }
}

void FeatureExtractor::ExtractWithoutRings(const RingScan& scan, Features* out) {
  facings_.clear();
  for (size_t band = 0; band + 1 < scan.ring_begin.size(); ++band) {
    for (uint32_t i = scan.ring_begin[band]; i < scan.ring_begin[band + 1]; ++i) {
      const RingPoint& p = scan.points[i];
      if (!map_thinner_.Insert(p.x, p.y, p.z)) continue;
      const auto look = neighbourhoods_.At(i, options_.surface_deviation_m);
      out->work.Add(Work::Kind::kNeighbours, look.neighbours);
      if (out->work.spent()) return;
      if (look.are == Surroundings::kUnclear) continue;
      const auto ring = static_cast<uint16_t>(band);
      if (look.are == Surroundings::kEdge) {
        if (p.range >= kOwnM && edge_thinner_.Insert(p.x, p.y, p.z))
          out->edges.push_back(ToTimed(p, 1, ring));
        continue;
      }
      const float smoothness = look.deviation_m / p.range;
      const TimedPoint point = ToTimed(p, std::exp(-smoothness / kSmoothnessScale), ring);
      out->map_surfaces.push_back(point);
      if (!surface_thinner_.Insert(p.x, p.y, p.z)) continue;
      out->surfaces.push_back(point);
      facings_.push_back(Facing(look.normal));
    }
  }
}

// If most of what is seen is ground, the few walls that observe motion along it would be outvoted.
void FeatureExtractor::Balance(std::vector<TimedPoint>* surfaces) {
  std::array<size_t, kFacings> count{}, seen{};
  for (const uint8_t facing : facings_) ++count[facing];
  size_t kept = 0;
  for (size_t i = 0; i < surfaces->size(); ++i) {
    const uint8_t facing = facings_[i];
    const size_t share = std::min(kMaxPerFacing, count[facing]);
    const size_t nth = seen[facing]++;
    // Evenly: as often as the share grows.
    if ((nth + 1) * share / count[facing] > nth * share / count[facing])
      (*surfaces)[kept++] = (*surfaces)[i];
  }
  surfaces->resize(kept);
}

void FeatureExtractor::ExtractSegment(const RingPoint* begin, const RingPoint* end, Features* out) {
  const int window = options_.half_window;
  const float edge2 = options_.edge_deviation_m * options_.edge_deviation_m;
  const float surface2 = options_.surface_deviation_m * options_.surface_deviation_m;
  if (end - begin <= 2 * window) return;
  Deviations deviations(begin + window, window);
  for (const RingPoint* p = begin + window; p + window < end; ++p) {
    const bool new_in_map = map_thinner_.Insert(p->x, p->y, p->z);
    const float deviation2 = deviations.SquaredAt(p);
    if (deviation2 > edge2) {
      edge_candidates_.push_back({p, std::sqrt(deviation2) / p->range});
      continue;
    }
    if (!new_in_map || !(deviation2 < surface2)) continue;
    if (Grazing(p[-window], *p, p[window])) continue;
    const float smoothness = std::sqrt(deviation2) / p->range;
    const TimedPoint point = ToTimed(*p, std::exp(-smoothness / kSmoothnessScale), ring_);
    out->map_surfaces.push_back(point);
    if (surface_thinner_.Insert(p->x, p->y, p->z)) out->surfaces.push_back(point);
  }
}

void FeatureExtractor::AddPole(const RingPoint* begin, const RingPoint* end, Features* out) const {
  const Eigen::Vector3f first = begin->Position(), last = end[-1].Position();
  const float width2 = (last - first).squaredNorm();
  if (width2 > options_.pole_width_m * options_.pole_width_m) return;
  if (width2 < kThinM * kThinM && begin->range < kThinFromM) return;
  TimedPoint pole = ToTimed(begin[(end - begin) / 2], 1, ring_);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const RingPoint* p = begin; p < end; ++p) sum += p->Position();
  pole.position = sum / static_cast<float>(end - begin);
  out->poles.push_back(pole);
}

void FeatureExtractor::KeepBestEdges(const RingPoint* ring_begin, const RingPoint* ring_end,
                                     Features* out) {
  const auto sector_of = [&](const RingPoint* p) {
    return (p - ring_begin) * options_.sectors / (ring_end - ring_begin);
  };
  for (size_t first = 0; first < edge_candidates_.size();) {
    size_t last = first;
    const auto sector = sector_of(edge_candidates_[first].point);
    while (last < edge_candidates_.size() && sector_of(edge_candidates_[last].point) == sector) {
      ++last;
    }
    const auto begin = edge_candidates_.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = edge_candidates_.begin() + static_cast<std::ptrdiff_t>(last);
    std::sort(begin, end, [](const EdgeCandidate& a, const EdgeCandidate& b) {
      return a.smoothness > b.smoothness;
    });
    int kept = 0;
    for (auto candidate = begin; candidate != end && kept < options_.edges_per_sector;
         ++candidate) {
      const RingPoint& p = *candidate->point;
      if (!edge_thinner_.Insert(p.x, p.y, p.z)) continue;
      out->edges.push_back(
          ToTimed(p, 1 - std::exp(-candidate->smoothness / kSmoothnessScale), ring_));
      ++kept;
    }
    first = last;
  }
}

}  // namespace isthmus::floam
