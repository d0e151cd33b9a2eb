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

  // The spectrum of an image of cells(); valid until the next call.
  const FftwComplex* Transform(const std::vector<float>& image) {
    std::copy(image.begin(), image.end(), real_.get());
    fftwf_execute(forward_);
    return spectrum_.get();
  }
  // The field of a product of spectra, which is gone then; valid until the next call.
  const float* Field(const std::vector<FftwComplex>& product) {
    std::copy(product.begin(), product.end(), product_.get());
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

// Adds the products of the reference's spectrum with that of an image, and with that of the same
// image turned by half a turn, which is its conjugate, but for the sign.
void AddBoth(const FftwComplex* reference, const FftwComplex* moved, float turned_sign, size_t bins,
             FftwComplex* product, FftwComplex* turned) {
  for (size_t i = 0; i < bins; ++i) {
    const float re = reference[i].real(), im = reference[i].imag();
    const float rr = re * moved[i].real(), ii = im * moved[i].imag();
    const float ri = re * moved[i].imag(), ir = im * moved[i].real();
    product[i] += FftwComplex(rr + ii, ir - ri);
    turned[i] += FftwComplex(turned_sign * (rr - ii), turned_sign * (ir + ri));
  }
}

// Normals turn round with the plan.
float SignTurned(size_t plane) {
  return plane == PlanImage::kNormalX || plane == PlanImage::kNormalY ? -1.0f : 1.0f;
}

}  // namespace

// The plan at all yaws of half a turn, transformed.
class PlanCorrelator::Turned {
 public:
  // Keeps what it transforms where that takes no more than so many bytes.
  Turned(const SessionPlan& plan, int size, size_t most_bytes) : plan_(plan), fft_(size) {
    is_kept_ = spectra_at_once() * kHalfTurn * sizeof(FftwComplex) <= most_bytes;
    spectra_.resize(spectra_at_once() * (is_kept_ ? kHalfTurn : 1));
    for (int k = 0; is_kept_ && k < kHalfTurn; ++k) Transform(k, &spectra_[k * spectra_at_once()]);
  }

  std::vector<PlanarPose> Peaks(const SessionPlan& a, const std::stop_token& stop) {
    const std::vector<FftwComplex> reference = Reference(a);
    std::vector<FftwComplex> product(fft_.bins()), turned(fft_.bins());
    std::vector<PlanarPose> peaks;
    for (int k = 0; k < kHalfTurn; ++k) {
      if (stop.stop_requested()) return {};
      if (!is_kept_) Transform(k, spectra_.data());
      const FftwComplex* moved = &spectra_[is_kept_ ? k * spectra_at_once() : 0];
      std::fill(product.begin(), product.end(), FftwComplex());
      std::fill(turned.begin(), turned.end(), FftwComplex());
      for (size_t plane = 0; plane < PlanImage::kPlanes; ++plane) {
        AddBoth(&reference[plane * fft_.bins()], moved + plane * fft_.bins(), SignTurned(plane),
                fft_.bins(), product.data(), turned.data());
      }
      FindPeaks(fft_.Field(product), fft_.size(), YawAt(k), a, plan_, &peaks);
      FindPeaks(fft_.Field(turned), fft_.size(), YawAt(k + kHalfTurn), a, plan_, &peaks);
    }
    return peaks;
  }

  size_t bytes() const { return spectra_.size() * sizeof(FftwComplex); }

 private:
  static constexpr int kHalfTurn = kPlanYaws / 2;
  static_assert(kPlanYaws % 2 == 0);

  static double YawAt(int k) { return 2 * M_PI * k / kPlanYaws; }
  size_t spectra_at_once() const { return PlanImage::kPlanes * fft_.bins(); }

  void Transform(int k, FftwComplex* spectra) {
    const PlanImage image = MakeMoved(plan_, YawAt(k), fft_.size());
    for (const auto& plane : image.planes) {
      spectra = std::copy_n(fft_.Transform(plane), fft_.bins(), spectra);
    }
  }
  // Divided by the number of cells: FFTW does not normalise.
  std::vector<FftwComplex> Reference(const SessionPlan& a) {
    std::vector<FftwComplex> reference;
    const PlanImage image = MakeReference(a, fft_.size());
    for (const auto& plane : image.planes) {
      const FftwComplex* spectrum = fft_.Transform(plane);
      reference.insert(reference.end(), spectrum, spectrum + fft_.bins());
    }
    for (FftwComplex& bin : reference) bin /= static_cast<float>(fft_.cells());
    return reference;
  }

  const SessionPlan& plan_;
  Fft fft_;
  bool is_kept_ = false;
  std::vector<FftwComplex> spectra_;  // By yaw, then plane; of one yaw at a time if not kept.
};

PlanCorrelator::PlanCorrelator(std::shared_ptr<const SessionPlan> moved)
    : moved_(std::move(moved)) {}

PlanCorrelator::~PlanCorrelator() = default;

PlanCorrelator::Turned& PlanCorrelator::TurnedFor(float cell_m, int size) {
  std::unique_ptr<Turned>& turned = turned_[{cell_m, size}];
  if (turned == nullptr) {
    auto coarse = coarse_.find(cell_m);
    if (coarse == coarse_.end()) coarse = coarse_.emplace(cell_m, Coarsen(*moved_, cell_m)).first;
    turned = std::make_unique<Turned>(coarse->second, size, kMaxTurnedBytes - bytes_);
    bytes_ = std::min(kMaxTurnedBytes, bytes_ + turned->bytes());
  }
  return *turned;
}

std::vector<PlanarPose> PlanCorrelator::Correlate(const SessionPlan& a, float cell_m, size_t count,
                                                  const std::stop_token& stop) {
  if (a.walls.empty() || moved_->walls.empty()) return {};
  const SessionPlan coarse = Coarsen(a, cell_m);
  Turned& turned = TurnedFor(cell_m, SizeFor((a.radius + moved_->radius) / cell_m + 4));
  return SuppressNeighbors(turned.Peaks(coarse, stop), moved_->center.cast<double>(), 4 * cell_m,
                           2.5 * 2 * M_PI / kPlanYaws, count);
}

}  // namespace isthmus::matching
