#include "server/matching/search/fft_correlator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "server/matching/search/fftw.h"
#include "server/matching/search/limits.h"

namespace isthmus::matching {
namespace {

// The next even number with no prime factor above 7, where FFTW is fast.
int FastSize(int least) {
  for (int size = std::max(2, least);; ++size) {
    int rest = size;
    for (const int factor : {2, 3, 5, 7}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1 && size % 2 == 0) return size;
  }
}

// Mean over a neighbourhood of frequencies, which wrap round from row to row.
std::vector<float> Smooth(const std::vector<float>& power, int columns, int rows) {
  std::vector<float> along(power.size()), smooth(power.size());
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      float sum = 0;
      const int from = std::max(0, x - kSpectrumReach);
      const int to = std::min(columns - 1, x + kSpectrumReach);
      for (int i = from; i <= to; ++i) sum += power[static_cast<size_t>(y) * columns + i];
      along[static_cast<size_t>(y) * columns + x] = sum / static_cast<float>(to - from + 1);
    }
  }
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      float sum = 0;
      for (int dy = -kSpectrumReach; dy <= kSpectrumReach; ++dy) {
        sum += along[static_cast<size_t>((y + dy + rows) % rows) * columns + x];
      }
      smooth[static_cast<size_t>(y) * columns + x] = sum / (2 * kSpectrumReach + 1);
    }
  }
  return smooth;
}

}  // namespace

struct FftCorrelator::Buffers {
  int width = 0, rows = 0;
  size_t bins = 0;  // Bins of a real image's spectrum.
  std::array<RealBuffer, BirdsEyeImage::kPlanes> moved;
  std::array<ComplexBuffer, BirdsEyeImage::kPlanes> reference;
  ComplexBuffer spectrum, product;
  RealBuffer scores;
  fftwf_plan forward = nullptr, backward = nullptr;

  size_t size() const { return static_cast<size_t>(width) * rows; }
  void Forward(float* image) { fftwf_execute_dft_r2c(forward, image, Fftw(spectrum)); }
};

FftCorrelator::FftCorrelator(const BirdsEyeImage& reference, int moved_size, bool whiten)
    : buffers_(std::make_unique<Buffers>()) {
  Buffers& b = *buffers_;
  b.width = FastSize(reference.width + moved_size);
  b.rows = FastSize(reference.rows + moved_size);
  b.bins = static_cast<size_t>(b.rows) * (b.width / 2 + 1);
  for (auto& plane : b.moved) plane = MakeReal(b.size());
  b.spectrum = MakeComplex(b.bins);
  b.product = MakeComplex(b.bins);
  b.scores = MakeReal(b.size());
  {
    MutexLock lock(&fftw_planner_mutex);
    b.forward = fftwf_plan_dft_r2c_2d(b.rows, b.width, b.scores.get(), Fftw(b.spectrum),
                                      FFTW_ESTIMATE | FFTW_PRESERVE_INPUT);
    b.backward =
        fftwf_plan_dft_c2r_2d(b.rows, b.width, Fftw(b.product), b.scores.get(), FFTW_ESTIMATE);
  }
  for (int k = 0; k < BirdsEyeImage::kPlanes; ++k) {
    std::fill_n(b.scores.get(), b.size(), 0.0f);
    for (int y = 0; y < reference.rows; ++y) {
      std::copy_n(reference.planes[k].begin() + static_cast<size_t>(y) * reference.width,
                  reference.width, b.scores.get() + static_cast<size_t>(y) * b.width);
    }
    b.Forward(b.scores.get());
    b.reference[k] = MakeComplex(b.bins);
    std::copy_n(b.spectrum.get(), b.bins, b.reference[k].get());
  }
  if (whiten) Whiten();
}

void FftCorrelator::Whiten() {
  Buffers& b = *buffers_;
  const int columns = b.width / 2 + 1;
  std::vector<float> power(b.bins, 0.0f);
  for (int k = 0; k < BirdsEyeImage::kFree; ++k) {  // Free space says where walls are not.
    for (size_t i = 0; i < b.bins; ++i) power[i] += std::norm(b.reference[k][i]);
  }
  const double mean =
      std::accumulate(power.begin(), power.end(), 0.0) / static_cast<double>(b.bins);
  const std::vector<float> smooth = Smooth(power, columns, b.rows);
  for (size_t i = 0; i < b.bins; ++i) {
    const double share = smooth[i] / std::max(mean, 1e-12);
    const auto weight = static_cast<float>(1 / std::sqrt(share + kLeastPower));
    for (auto& plane : b.reference) plane[i] *= weight;
  }
}

FftCorrelator::~FftCorrelator() {
  MutexLock lock(&fftw_planner_mutex);
  fftwf_destroy_plan(buffers_->forward);
  fftwf_destroy_plan(buffers_->backward);
}

int FftCorrelator::width() const { return buffers_->width; }
int FftCorrelator::rows() const { return buffers_->rows; }
float* FftCorrelator::plane(int k) { return buffers_->moved[k].get(); }

const float* FftCorrelator::Correlate() {
  Buffers& b = *buffers_;
  std::fill_n(b.product.get(), b.bins, FftwComplex());
  // FFTW does not normalise.
  const float scale = 1.0f / static_cast<float>(b.size());
  for (int k = 0; k < BirdsEyeImage::kPlanes; ++k) {
    b.Forward(b.moved[k].get());
    std::fill_n(b.moved[k].get(), b.size(), 0.0f);
    AddCorrelation(b.reference[k].get(), b.spectrum.get(), b.bins, scale, b.product.get());
  }
  fftwf_execute(b.backward);
  return b.scores.get();
}

}  // namespace isthmus::matching
