#include "server/matching/index/plan_correlator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "server/matching/index/limits.h"
#include "server/matching/index/plan_image.h"
#include "server/matching/search/fftw.h"

namespace isthmus::matching {
namespace {

// Square images that wrap round.
class Fft {
 public:
  explicit Fft(int size)
      : size_(size),
        real_(MakeReal(cells())),
        spectrum_(MakeComplex(bins())),
        product_(MakeComplex(bins())) {
    MutexLock lock(&fftw_planner_mutex);
    forward_ = fftwf_plan_dft_r2c_2d(size, size, real_.get(), Fftw(spectrum_), FFTW_ESTIMATE);
    backward_ = fftwf_plan_dft_c2r_2d(size, size, Fftw(product_), real_.get(), FFTW_ESTIMATE);
  }
  ~Fft() {
    MutexLock lock(&fftw_planner_mutex);
    fftwf_destroy_plan(forward_);
    fftwf_destroy_plan(backward_);
  }
  Fft(const Fft&) = delete;
  Fft& operator=(const Fft&) = delete;

  int size() const { return size_; }
  size_t cells() const { return static_cast<size_t>(size_) * size_; }
  size_t bins() const { return static_cast<size_t>(size_) * (size_ / 2 + 1); }

  // Of an image of cells(); valid until the next call.
  const FftwComplex* Transform(const std::vector<float>& image) {
    std::copy(image.begin(), image.end(), real_.get());
    fftwf_execute(forward_);
    return spectrum_.get();
  }
  void Clear() { std::fill_n(product_.get(), bins(), FftwComplex()); }
  // Adds the correlation of `moved`, transformed here, with a reference that was before.
  void Correlate(const std::vector<FftwComplex>& reference, const std::vector<float>& moved) {
    const FftwComplex* spectrum = Transform(moved);
    AddCorrelation(reference.data(), spectrum, bins(), 1.0f / static_cast<float>(cells()),
                   product_.get());
  }
  // The field of what was added; valid until the next call.
  const float* Field() {
    fftwf_execute(backward_);
    return real_.get();
  }

 private:
  const int size_;
  RealBuffer real_;
  ComplexBuffer spectrum_, product_;
  fftwf_plan forward_ = nullptr, backward_ = nullptr;
};

// Sizes where FFTW is fast.
int SizeFor(double cells) {
  for (const int size : {32, 48, 64, 80, 96, 128, 160, 192, 256, 320, 384}) {
    if (cells <= size) return size;
  }
  return 512;  // Beyond, the ends of the maps wrap round onto each other.
}

void KeepPeak(const PlanarPose& peak, std::vector<PlanarPose>* peaks) {
  const auto place =
      std::lower_bound(peaks->begin(), peaks->end(), peak.score,
                       [](const PlanarPose& other, double score) { return other.score >= score; });
  peaks->insert(place, peak);
  if (peaks->size() > kPlanPeaks) peaks->pop_back();
}

// Adds the local maxima of the field to the best peaks of all.
void FindPeaks(const float* field, int size, double yaw, const SessionPlan& a, const SessionPlan& b,
               std::vector<PlanarPose>* peaks) {
  const Eigen::Vector2d turned = Eigen::Rotation2Dd(yaw) * b.center.cast<double>();
  const auto row = [&](int y) { return field + static_cast<size_t>((y + size) % size) * size; };
  for (int y = 0; y < size; ++y) {
    const float *at = row(y), *below = row(y - 1), *above = row(y + 1);
    for (int x = 0; x < size; ++x) {
      const float score = at[x];
      if (!(score > 0)) continue;
      if (peaks->size() == kPlanPeaks && score <= peaks->back().score) continue;
      const int left = (x + size - 1) % size, right = (x + 1) % size;
      if (at[left] > score || at[right] >= score || below[x] > score || above[x] >= score) continue;
      const Eigen::Vector2d shift(x > size / 2 ? x - size : x, y > size / 2 ? y - size : y);
      KeepPeak({yaw, a.center.cast<double>() + a.cell_m * shift - turned, score}, peaks);
    }
  }
}

}  // namespace

std::vector<PlanarPose> CorrelatePlans(const SessionPlan& a, const SessionPlan& b, size_t count,
                                       const std::stop_token& stop) {
  if (a.walls.empty() || b.walls.empty()) return {};
  Fft fft(SizeFor((a.radius + b.radius) / a.cell_m + 4));
  std::array<std::vector<FftwComplex>, PlanImage::kPlanes> reference;
  const PlanImage image = MakeReference(a, fft.size());
  for (size_t k = 0; k < reference.size(); ++k) {
    const FftwComplex* spectrum = fft.Transform(image.planes[k]);
    reference[k].assign(spectrum, spectrum + fft.bins());
  }
  std::vector<PlanarPose> peaks;
  for (int k = 0; k < kPlanYaws; ++k) {
    if (stop.stop_requested()) return {};
    const double yaw = 2 * M_PI * k / kPlanYaws;
    const PlanImage moved = MakeMoved(b, yaw, fft.size());
    fft.Clear();
    for (size_t i = 0; i < reference.size(); ++i) fft.Correlate(reference[i], moved.planes[i]);
    FindPeaks(fft.Field(), fft.size(), yaw, a, b, &peaks);
  }
  return SuppressNeighbors(std::move(peaks), b.center.cast<double>(), 4 * a.cell_m,
                           2.5 * 2 * M_PI / kPlanYaws, count);
}

}  // namespace isthmus::matching
