#include "floam/ring_inference.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "floam/azimuth.h"

namespace isthmus::floam {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr int kMaxRings = 256;

float Elevation(const ScanPoint& p) { return FastAtan2(p.z, std::sqrt(p.x * p.x + p.y * p.y)); }

}  // namespace

int RingsByWrap(const std::vector<float>& azimuths, double turns, std::vector<uint16_t>* rings) {
  const float sense = turns > 0 ? 1.F : -1.F;
  rings->resize(azimuths.size());
  int ring = 0;
  float last = 0;      // Azimuth in the sense of the order, in [0, 2 pi) from +x.
  float travel = kPi;  // Since the ring began; a wrap right after another is noise at the seam.
  for (size_t i = 0; i < azimuths.size(); ++i) {
    float a = sense * azimuths[i];
    if (a < 0) a += 2 * kPi;
    if (i > 0) {
      travel += WrapOnce(a - last);
      if (last - a > kPi && travel > kPi && ring + 1 < kMaxRings) {
        ++ring;
        travel = 0;
      }
    }
    last = a;
    (*rings)[i] = static_cast<uint16_t>(ring);
  }
  return ring + 1;
}

std::vector<double> FindElevations(const Scan& scan) {
  constexpr float kBin = 0.1F * kPi / 180;  // Finer than the rings of any 128-laser sensor.
  constexpr int kBins = 1801;
  std::vector<float> histogram(kBins, 0.F);
  for (const ScanPoint& p : scan.points) {
    const int bin = static_cast<int>(std::lround(Elevation(p) / kBin)) + kBins / 2;
    if (bin >= 0 && bin < kBins) histogram[bin] += 1;
  }
  // A ring holds more than its share of the points within 0.2 degrees.
  const float floor = 0.15F * static_cast<float>(scan.points.size()) / kMaxRings;
  std::vector<double> elevations;
  double weight = 0, moment = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    const bool valley = bin > 0 && weight > 0 && bin + 1 < kBins &&
                        histogram[bin] < 0.5F * histogram[bin - 1] &&
                        histogram[bin] <= histogram[bin + 1];
    if (histogram[bin] > 0 && !valley) {
      weight += histogram[bin];
      moment += histogram[bin] * (bin - kBins / 2);
      continue;
    }
    if (weight > floor) elevations.push_back(moment / weight * kBin);
    weight = histogram[bin];
    moment = histogram[bin] * (bin - kBins / 2);
  }
  if (elevations.size() > kMaxRings) elevations.clear();
  return elevations;
}

double RingsByElevation(const Scan& scan, const std::vector<double>& elevations,
                        std::vector<uint16_t>* rings) {
  rings->resize(scan.points.size());
  double sum = 0;
  for (size_t i = 0; i < scan.points.size(); ++i) {
    const double elevation = Elevation(scan.points[i]);
    size_t k =
        std::lower_bound(elevations.begin(), elevations.end(), elevation) - elevations.begin();
    if (k == elevations.size() ||
        (k > 0 && elevation - elevations[k - 1] < elevations[k] - elevation)) {
      --k;
    }
    (*rings)[i] = static_cast<uint16_t>(k);
    const double below = k > 0 ? elevations[k] - elevations[k - 1] : 0.1;
    const double above = k + 1 < elevations.size() ? elevations[k + 1] - elevations[k] : 0.1;
    sum += std::min(0.5, std::abs(elevation - elevations[k]) / std::min(below, above));
  }
  return scan.points.empty() ? 0 : sum / static_cast<double>(scan.points.size());
}

}  // namespace isthmus::floam
