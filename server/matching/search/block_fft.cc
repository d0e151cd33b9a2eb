#include "server/matching/search/block_fft.h"

#include <algorithm>

#include "server/matching/search/fftw.h"

namespace isthmus::matching {

struct BlockFft::Plans {
  ~Plans() {
    MutexLock lock(&fftw_planner_mutex);
    for (const fftwf_plan plan : {rows, back_rows, columns, back_columns}) fftwf_destroy_plan(plan);
  }

  fftwf_plan rows = nullptr, back_rows = nullptr, columns = nullptr, back_columns = nullptr;
  ComplexBuffer lines;  // The spectra of kBlock rows, one by one.
};

BlockFft::BlockFft(int width, int rows)
    : width_(width),
      rows_(rows),
      blocks_(RoomFor(columns()) / kBlock),
      plans_(std::make_unique<Plans>()) {
  const int count = kBlock, line = static_cast<int>(blocks_ * kBlock);
  plans_->lines = MakeComplex(kBlock * blocks_ * kBlock);
  fftwf_complex* lines = Fftw(plans_->lines);
  const RealBuffer image = MakeReal(kBlock * static_cast<size_t>(width_));
  const ComplexBuffer from = MakeComplex(block_size()), to = MakeComplex(block_size());
  const auto plan_columns = [&](int sign) {
    return fftwf_plan_many_dft(1, &rows_, count, Fftw(from), nullptr, count, 1, Fftw(to), nullptr,
                               count, 1, sign, FFTW_ESTIMATE);
  };
  MutexLock lock(&fftw_planner_mutex);
  plans_->rows = fftwf_plan_many_dft_r2c(1, &width_, count, image.get(), nullptr, 1, width_, lines,
                                         nullptr, 1, line, FFTW_ESTIMATE);
  plans_->back_rows = fftwf_plan_many_dft_c2r(1, &width_, count, lines, nullptr, 1, line,
                                              image.get(), nullptr, 1, width_, FFTW_ESTIMATE);
  plans_->columns = plan_columns(FFTW_FORWARD);
  plans_->back_columns = plan_columns(FFTW_BACKWARD);
}

BlockFft::~BlockFft() = default;

void BlockFft::TransformRows(float* image, int count, Complex* rows) {
  const size_t line = blocks_ * kBlock;
  for (size_t y = 0; y < static_cast<size_t>(count); y += kBlock) {
    fftwf_execute_dft_r2c(plans_->rows, image + y * width_, Fftw(plans_->lines));
    const size_t lines = std::min(kBlock, static_cast<size_t>(rows_) - y);
    for (size_t block = 0; block < blocks_; ++block) {
      const Complex* from = plans_->lines.get() + block * kBlock;
      Complex* to = rows + block * block_size() + y * kBlock;
      for (size_t i = 0; i < lines; ++i) CopyBlock(from + i * line, to + i * kBlock);
    }
  }
}

void BlockFft::TransformColumns(Complex* rows, Complex* spectrum) const {
  fftwf_execute_dft(plans_->columns, Fftw(rows), Fftw(spectrum));
}

void BlockFft::InvertColumns(Complex* spectrum, Complex* rows) const {
  fftwf_execute_dft(plans_->back_columns, Fftw(spectrum), Fftw(rows));
}

void BlockFft::InvertRows(const Complex* rows, float* image) {
  const size_t line = blocks_ * kBlock;
  for (size_t y = 0; y < static_cast<size_t>(rows_); y += kBlock) {
    const size_t lines = std::min(kBlock, static_cast<size_t>(rows_) - y);
    for (size_t block = 0; block < blocks_; ++block) {
      const Complex* from = rows + block * block_size() + y * kBlock;
      Complex* to = plans_->lines.get() + block * kBlock;
      for (size_t i = 0; i < lines; ++i) CopyBlock(from + i * kBlock, to + i * line);
    }
    fftwf_execute_dft_c2r(plans_->back_rows, Fftw(plans_->lines), image + y * width_);
  }
}

}  // namespace isthmus::matching
