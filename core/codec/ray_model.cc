#include "core/codec/ray_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isthmus::codec {
namespace {

constexpr size_t kSamplesPerRing = 96;
constexpr size_t kTurnSamples = 1024;  // Samples of one ring, for the speed of the turn.
constexpr double kNearest = 100;       // Steps; what is nearer tells no direction.
// Rings whose distances vary less (steps, one sigma) do not tell offsets from directions.
constexpr double kLeastSpread = 300;
constexpr double kMostOffset = 500;  // Steps; lasers sit within decimetres of the axis.

double Wrap(double turns) { return turns - std::nearbyint(turns); }

double Azimuth(const RayPoints& points, size_t i) {
  return std::atan2(static_cast<double>(points.y[i]), static_cast<double>(points.x[i])) /
         (2 * std::numbers::pi);
}

double Rho(const RayPoints& points, size_t i) {
  const double x = points.x[i], y = points.y[i];
  return std::sqrt(x * x + y * y);
}

bool Usable(const RayPoints& points, size_t i) {
  return points.is_return[i] != 0 && Rho(points, i) > kNearest;
}

// A line through (u, v), by least squares.
class Line {
 public:
  void Add(double u, double v) {
    n_ += 1;
    u_ += u;
    v_ += v;
    uu_ += u * u;
    uv_ += u * v;
  }
  // Through the origin where u varies less than `least_spread` (one sigma) or the offset would be
  // more than `most`.
  void Solve(double least_spread, double most, double* slope, double* offset) const {
    *offset = 0;
    *slope = uu_ > 0 ? uv_ / uu_ : 0;
    const double spread = n_ * uu_ - u_ * u_;
    if (n_ < 8 || spread < n_ * n_ * least_spread * least_spread) return;
    const double with_offset = (n_ * uv_ - u_ * v_) / spread;
    const double at_zero = (v_ - with_offset * u_) / n_;
    if (std::abs(at_zero) > most) return;
    *slope = with_offset;
    *offset = at_zero;
  }

 private:
  double n_ = 0, u_ = 0, v_ = 0, uu_ = 0, uv_ = 0;
};

// Turns per unit of time, from neighbours within one ring; 0 where they tell none.
double FitTurn(const RayPoints& points) {
  const size_t n = points.x.size();
  size_t middle = n / 2;
  while (middle < n && !Usable(points, middle)) ++middle;
  if (middle == n) return 0;
  std::vector<double> azimuths, times;
  const auto take = [&](size_t i) {
    if (points.ring[i] == points.ring[middle] && Usable(points, i)) {
      azimuths.push_back(Azimuth(points, i));
      times.push_back(points.time[i]);
    }
  };
  for (size_t i = n / 8; i < n && azimuths.size() < kTurnSamples; ++i) take(i);
  std::vector<double> speeds;
  for (size_t i = 1; i < azimuths.size(); ++i) {
    const double turned = Wrap(azimuths[i] - azimuths[i - 1]), took = times[i] - times[i - 1];
    if (took != 0 && std::abs(turned) < 0.1) speeds.push_back(turned / took);
  }
  if (speeds.size() < 16) return 0;
  std::nth_element(speeds.begin(), speeds.begin() + speeds.size() / 2, speeds.end());
  const double speed = speeds[speeds.size() / 2];
  Line line;
  for (size_t i = 0; i < azimuths.size(); ++i) {
    const double took = times[i] - times[0];
    line.Add(took, Wrap(azimuths[i] - azimuths[0] - speed * took));
  }
  double correction = 0, start = 0;
  line.Solve(0, 1, &correction, &start);
  return std::isfinite(speed + correction) ? speed + correction : 0;
}

struct RingFit {
  bool begun = false;
  double first_turn = 0;
  Line across, up;
};

}  // namespace

std::optional<RayModel> FitRays(const RayPoints& points, size_t rings) {
  RayModel model;
  model.turns_per_unit = FitTurn(points);
  if (model.turns_per_unit == 0) return std::nullopt;
  std::vector<RingFit> fits(rings);
  const size_t n = points.x.size();
  // Steps of the golden section meet all rings alike, however they are interleaved.
  const auto step = static_cast<size_t>(0.6180339887 * static_cast<double>(n)) | 1;
  const size_t samples = std::min(n, rings * kSamplesPerRing);
  for (size_t k = 0, i = 0; k < samples; ++k, i = (i + step) % n) {
    if (!Usable(points, i)) continue;
    RingFit& fit = fits[points.ring[i]];
    const double rho = Rho(points, i);
    const double turn = Azimuth(points, i) - model.turns_per_unit * points.time[i];
    if (!fit.begun) fit.first_turn = Wrap(turn);
    fit.begun = true;
    fit.across.Add(rho, rho * Wrap(turn - fit.first_turn) * 2 * std::numbers::pi);
    fit.up.Add(rho, points.z[i]);
  }
  for (const RingFit& fit : fits) {
    double angle = 0, side = 0, slope = 0, height = 0;
    fit.across.Solve(kLeastSpread, kMostOffset, &angle, &side);
    fit.up.Solve(kLeastSpread, kMostOffset, &slope, &height);
    model.rings.push_back({static_cast<float>(fit.first_turn + angle / (2 * std::numbers::pi)),
                           static_cast<float>(slope), static_cast<float>(side),
                           static_cast<float>(height)});
  }
  return model;
}

}  // namespace isthmus::codec
