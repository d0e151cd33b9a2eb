#include "floam/rings/ring_inference.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/angles.h"
#include "floam/rings/limits.h"

namespace isthmus::floam {
namespace {

struct Nearest {
  size_t ring;
  double misfit;  // In units of the spacing, at most a half.
};

Nearest FindNearest(const std::vector<double>& rings_at, double elevation) {
  size_t k = std::lower_bound(rings_at.begin(), rings_at.end(), elevation) - rings_at.begin();
  if (k == rings_at.size() || (k > 0 && elevation - rings_at[k - 1] < rings_at[k] - elevation)) {
    --k;
  }
  const double below = k > 0 ? rings_at[k] - rings_at[k - 1] : kOutermostSpacingRad;
  const double above =
      k + 1 < rings_at.size() ? rings_at[k + 1] - rings_at[k] : kOutermostSpacingRad;
  return {k, std::min(0.5, std::abs(elevation - rings_at[k]) / std::min(below, above))};
}

// Crosstalk between lasers makes heaps beside those of the rings, far lower than both neighbours.
void DropGhosts(std::vector<double>* peaks, std::vector<double>* weights) {
  while (true) {
    double least = kGhostShare;
    size_t ghost = 0;
    // The higher of the next two on a side: ghosts may come in pairs.
    const auto around = [&](size_t k, int side) {
      const double next = (*weights)[k + side];
      const bool more = side < 0 ? k > 1 : k + 2 < weights->size();
      return more ? std::max(next, (*weights)[k + 2 * side]) : next;
    };
    for (size_t k = 1; k + 1 < peaks->size(); ++k) {
      const double share = (*weights)[k] / std::min(around(k, -1), around(k, 1));
      if (share < least) ghost = k, least = share;
    }
    if (ghost == 0) return;
    peaks->erase(peaks->begin() + static_cast<std::ptrdiff_t>(ghost));
    weights->erase(weights->begin() + static_cast<std::ptrdiff_t>(ghost));
  }
}

double Elevation(int bin) {
  return (bin - kElevationBins / 2) * static_cast<double>(kElevationBinRad);
}

}  // namespace

void ComputeElevations(const Scan& scan, const BeamOrigin& origin, std::vector<float>* elevations) {
  elevations->resize(scan.points.size());
  for (size_t i = 0; i < scan.points.size(); ++i) {
    const ScanPoint& p = scan.points[i];
    const float outwards = std::sqrt(p.x * p.x + p.y * p.y) - origin.outwards_m;
    (*elevations)[i] = FastAtan2(p.z - origin.up_m, outwards);
  }
}

BeamOrigin FindBeamOrigin(const Scan& scan) {
  Scan sample;
  const size_t stride = scan.points.size() / kOriginSample + 1;
  for (size_t i = 0; i < scan.points.size(); i += stride) sample.points.push_back(scan.points[i]);
  std::vector<float> elevations;
  const auto sharpness = [&](const BeamOrigin& origin) {
    ComputeElevations(sample, origin, &elevations);
    ElevationHistogram histogram;
    histogram.Add(sample, elevations);
    return histogram.Sharpness();
  };
  BeamOrigin best;
  double most = kClearlySharper * sharpness(best);
  const auto look = [&](const BeamOrigin& origin) {
    const double value = sharpness(origin);
    if (value > most) best = origin, most = value;
  };
  for (int up = -10; up <= 10; ++up) {
    for (const float outwards : {0.F, 0.015F, 0.03F})
      look({0.01F * static_cast<float>(up), outwards});
  }
  for (const float step : {0.005F, 0.002F}) {
    const BeamOrigin center = best;
    if (center.up_m == 0 && center.outwards_m == 0) break;
    for (const float up : {-step, 0.F, step}) {
      for (const float out : {-step, 0.F, step}) look({center.up_m + up, center.outwards_m + out});
    }
  }
  return best;
}

void ComputeAzimuths(const Scan& scan, std::vector<float>* azimuths) {
  azimuths->resize(scan.points.size());
  for (size_t i = 0; i < scan.points.size(); ++i) {
    (*azimuths)[i] = FastAtan2(scan.points[i].y, scan.points[i].x);
  }
}

double CountTurns(const std::vector<float>& azimuths) {
  double travelled = 0;
  for (size_t i = 1; i < azimuths.size(); ++i) {
    travelled += WrapOnce(azimuths[i] - azimuths[i - 1]);
  }
  return travelled / (2 * kPi);
}

float FindSeam(const std::vector<float>& azimuths, const std::vector<float>& elevations) {
  constexpr int kSectors = 360;  // Layout: of a degree each.
  // From ring to ring elevation always jumps up, or always down; at the borders of things both.
  std::vector<int> jumps(kSectors, 0);
  std::vector<std::pair<int, float>> seams;  // Sector, and azimuth between the two points.
  for (size_t i = 1; i < azimuths.size(); ++i) {
    const float jump = elevations[i] - elevations[i - 1];
    if (std::abs(jump) < kSeamJumpRad) continue;
    const float seam = WrapOnce(azimuths[i] + 0.5F * WrapOnce(azimuths[i - 1] - azimuths[i]));
    const float sector = (seam + kPi) / (2 * kPi) * kSectors;
    seams.emplace_back(std::clamp(static_cast<int>(sector), 0, kSectors - 1), seam);
    jumps[seams.back().first] += jump > 0 ? 1 : -1;
  }
  // A sector's border may be where rings begin.
  int best = 0, most = 0;
  for (int k = 0; k < kSectors; ++k) {
    const int sum = std::abs(jumps[k] + jumps[(k + 1) % kSectors]);
    if (sum > most) best = k, most = sum;
  }
  if (most < 2) return azimuths.front();
  const float border = WrapOnce((static_cast<float>(best) + 1) / kSectors * 2 * kPi - kPi);
  std::vector<float> offsets;
  for (const auto& [sector, seam] : seams) {
    if (sector == best || sector == (best + 1) % kSectors)
      offsets.push_back(WrapOnce(seam - border));
  }
  const auto middle = offsets.begin() + static_cast<std::ptrdiff_t>(offsets.size() / 2);
  std::nth_element(offsets.begin(), middle, offsets.end());
  return WrapOnce(border + *middle);
}

int RingsByWrap(const std::vector<float>& azimuths, double turns, float seam,
                std::vector<uint16_t>* rings) {
  const float sense = turns > 0 ? 1.F : -1.F;
  rings->resize(azimuths.size());
  int ring = 0;
  float last = 0;      // Azimuth in the sense of the order, in [0, 2 pi) from the seam.
  float travel = kPi;  // Since the ring began; a wrap right after another is noise at the seam.
  for (size_t i = 0; i < azimuths.size(); ++i) {
    float a = sense * WrapOnce(azimuths[i] - seam);
    if (a < 0) a += 2 * kPi;
    if (i > 0) {
      travel += WrapOnce(a - last);
      if (last - a > kPi && travel > kPi && ring + 1 < kMaxInferredRings) {
        ++ring;
        travel = 0;
      }
    }
    last = a;
    (*rings)[i] = static_cast<uint16_t>(ring);
  }
  return ring + 1;
}

ElevationHistogram::ElevationHistogram() : counts_(kElevationBins, 0.F) {}

void ElevationHistogram::Add(const Scan& scan, const std::vector<float>& elevations) {
  for (size_t i = 0; i < elevations.size(); ++i) {
    const ScanPoint& p = scan.points[i];
    if (p.x * p.x + p.y * p.y + p.z * p.z < kClearElevationM * kClearElevationM) continue;
    const int bin =
        static_cast<int>(std::lround(elevations[i] / kElevationBinRad)) + kElevationBins / 2;
    if (bin < 0 || bin >= kElevationBins) continue;
    counts_[bin] += 1;
    total_ += 1;
  }
}

std::vector<double> ElevationHistogram::Peaks() const {
  std::vector<double> best;
  double least = 0.5;
  // The sharpness of rings differs between sensors and scenes: the width that explains most.
  for (const int width : {1, 2, 4, 8, 12}) {
    std::vector<double> peaks = PeaksOfWidth(width);
    if (peaks.empty() || peaks.size() > kMaxInferredRings) continue;
    const double misfit = Misfit(peaks);
    if (misfit >= least) continue;
    least = misfit;
    best = std::move(peaks);
  }
  return best;
}

double ElevationHistogram::Sharpness() const {
  const int width = 2;  // A tenth of a degree, both sides and the middle.
  double sum = 0;
  for (int bin = width; bin + width < kElevationBins; ++bin) {
    double count = 0;
    for (int j = -width; j <= width; ++j) count += counts_[bin + j];
    sum += count * counts_[bin];
  }
  return sum / (total_ * total_ + 1);
}

std::vector<double> ElevationHistogram::PeaksOfWidth(int width) const {
  // A ring holds more than its share of the points, were there as many as can be.
  const auto floor = static_cast<float>(0.15 * total_ / kMaxInferredRings);
  std::vector<double> peaks, weights;
  double weight = 0, moment = 0;  // Since the last valley.
  float top = 0, low = 0;         // Since the last valley.
  bool falling = false;           // A ring makes a heap twice as high as the valleys beside it.
  const auto finish = [&] {
    if (weight > floor) {
      peaks.push_back(moment / weight);
      weights.push_back(weight);
    }
    weight = moment = 0;
    top = 0;
    falling = false;
  };
  for (int bin = width; bin + width < kElevationBins; ++bin) {
    float count = 0;
    for (int j = -width; j <= width; ++j) count += counts_[bin + j];
    if (falling && count > 2 * low && count > floor) finish();
    if (!falling && count < 0.5F * top) falling = true, low = count;
    if (falling) low = std::min(low, count);
    top = std::max(top, count);
    weight += counts_[bin];
    moment += counts_[bin] * Elevation(bin);
  }
  finish();
  DropGhosts(&peaks, &weights);
  return peaks;
}

double ElevationHistogram::Misfit(const std::vector<double>& elevations) const {
  double sum = 0;
  for (int bin = 0; bin < kElevationBins; ++bin) {
    if (counts_[bin] > 0) sum += counts_[bin] * FindNearest(elevations, Elevation(bin)).misfit;
  }
  return sum / total_;
}

double RingsByElevation(const std::vector<float>& elevations, const std::vector<double>& rings_at,
                        std::vector<uint16_t>* rings) {
  rings->resize(elevations.size());
  double sum = 0;
  for (size_t i = 0; i < elevations.size(); ++i) {
    const Nearest nearest = FindNearest(rings_at, elevations[i]);
    (*rings)[i] = static_cast<uint16_t>(nearest.ring);
    sum += nearest.misfit;
  }
  return elevations.empty() ? 0 : sum / static_cast<double>(elevations.size());
}

}  // namespace isthmus::floam
