#include "server/matching/search/fft_correlator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "server/matching/search/block_fft.h"
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
  Buffers(int wide, int high, int size)
      : width(wide), rows(high), moved_size(size), fft(wide, high) {
    for (auto& plane : moved) plane = MakeReal(BlockFft::RoomFor(moved_size) * width);
    for (auto* planes : {&moved_by_rows, &reference}) {
      for (auto& plane : *planes) plane = MakeComplex(fft.size());
    }
    product_by_rows = MakeComplex(fft.size());
    spectrum = MakeComplex(fft.block_size());
    product = MakeComplex(fft.block_size());
    scores = MakeReal(BlockFft::RoomFor(rows) * width);
  }

  int width, rows, moved_size;
  BlockFft fft;
  std::array<RealBuffer, BirdsEyeImage::kPlanes> moved;
  std::array<ComplexBuffer, BirdsEyeImage::kPlanes> moved_by_rows, reference;
  ComplexBuffer product_by_rows;
  ComplexBuffer spectrum, product;  // A block.
  RealBuffer scores;
};

FftCorrelator::FftCorrelator(const BirdsEyeImage& reference, int moved_size, bool whiten)
    : buffers_(std::make_unique<Buffers>(FastSize(reference.width + moved_size),
                                         FastSize(reference.rows + moved_size), moved_size)) {
  Buffers& b = *buffers_;
  for (int k = 0; k < BirdsEyeImage::kPlanes; ++k) {
    for (int y = 0; y < reference.rows; ++y) {
      std::copy_n(reference.planes[k].begin() + static_cast<size_t>(y) * reference.width,
                  reference.width, b.scores.get() + static_cast<size_t>(y) * b.width);
    }
    b.fft.TransformRows(b.scores.get(), reference.rows, b.product_by_rows.get());
    for (size_t i = 0; i < b.fft.size(); i += b.fft.block_size()) {
      b.fft.TransformColumns(b.product_by_rows.get() + i, b.reference[k].get() + i);
    }
  }
  if (whiten) Whiten();
}

void FftCorrelator::Whiten() {
  Buffers& b = *buffers_;
  const int columns = b.fft.columns();
  std::vector<float> power(static_cast<size_t>(columns) * b.rows, 0.0f);
  const auto for_all = [&](const auto& call) {
    for (int y = 0; y < b.rows; ++y) {
      for (int x = 0; x < columns; ++x)
        call(static_cast<size_t>(y) * columns + x, b.fft.Index(x, y));
    }
  };
  for (int k = 0; k < BirdsEyeImage::kFree; ++k) {  // Free space says where walls are not.
    for_all([&](size_t i, size_t bin) { power[i] += std::norm(b.reference[k][bin]); });
  }
  const double mean =
      std::accumulate(power.begin(), power.end(), 0.0) / static_cast<double>(power.size());
  const std::vector<float> smooth = Smooth(power, columns, b.rows);
  for_all([&](size_t i, size_t bin) {
    const double share = smooth[i] / std::max(mean, 1e-12);
    const auto weight = static_cast<float>(1 / std::sqrt(share + kLeastPower));
    for (auto& plane : b.reference) plane[bin] *= weight;
  });
}

FftCorrelator::~FftCorrelator() = default;

int FftCorrelator::width() const { return buffers_->width; }
int FftCorrelator::rows() const { return buffers_->rows; }
int FftCorrelator::moved_size() const { return buffers_->moved_size; }
float* FftCorrelator::plane(int k) { return buffers_->moved[k].get(); }

const float* FftCorrelator::Correlate() {
  Buffers& b = *buffers_;
  for (int k = 0; k < BirdsEyeImage::kPlanes; ++k) {
    b.fft.TransformRows(b.moved[k].get(), b.moved_size, b.moved_by_rows[k].get());
    std::fill_n(b.moved[k].get(), static_cast<size_t>(b.moved_size) * b.width, 0.0f);
  }
  // FFTW does not normalise.
  const float scale = 1.0f / static_cast<float>(static_cast<size_t>(b.width) * b.rows);
  const size_t size = b.fft.block_size();
  for (size_t i = 0; i < b.fft.size(); i += size) {
    std::fill_n(b.product.get(), size, FftwComplex());
    for (int k = 0; k < BirdsEyeImage::kPlanes; ++k) {
      b.fft.TransformColumns(b.moved_by_rows[k].get() + i, b.spectrum.get());
      AddCorrelation(b.reference[k].get() + i, b.spectrum.get(), size, scale, b.product.get());
    }
    b.fft.InvertColumns(b.product.get(), b.product_by_rows.get() + i);
  }
  b.fft.InvertRows(b.product_by_rows.get(), b.scores.get());
  return b.scores.get();
}

}  // namespace isthmus::matching
