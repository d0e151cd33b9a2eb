// Transforms of real images by FFT whose spectra lie in blocks of a few columns, so that all that
// is done along the columns of a block stays in the processor's cache.
#pragma once

#include <complex>
#include <cstddef>
#include <cstring>
#include <memory>

namespace isthmus::matching {

// Unnormalised. Spectra and rows' spectra are arrays of size() numbers, block by block, row by row
// within one: see Index. Not thread safe (a buffer is reused).
class BlockFft {
 public:
  using Complex = std::complex<float>;
  BlockFft(int width, int rows);  // Both even.
  ~BlockFft();
  BlockFft(const BlockFft&) = delete;
  BlockFft& operator=(const BlockFft&) = delete;

  int columns() const { return width_ / 2 + 1; }  // The others are conjugates of these.
  size_t blocks() const { return blocks_; }
  size_t block_size() const { return kBlock * static_cast<size_t>(rows_); }
  size_t size() const { return blocks_ * block_size(); }
  size_t Index(int x, int y) const {
    return (static_cast<size_t>(x) / kBlock * rows_ + y) * kBlock + static_cast<size_t>(x) % kBlock;
  }
  // Rows that an image of so many needs room for: what is done along rows is done to several.
  static size_t RoomFor(int rows) {
    return (static_cast<size_t>(rows) + kBlock - 1) / kBlock * kBlock;
  }

  // Transforms the first `count` rows of an image, which has room for them; the other rows' spectra
  // stay as they are.
  void TransformRows(float* image, int count, Complex* rows);
  // Take a block of the rows' spectra to one of the spectrum, in another array, and back.
  void TransformColumns(Complex* rows, Complex* spectrum) const;
  void InvertColumns(Complex* spectrum, Complex* rows) const;
  // Makes all rows of an image, which has room for them.
  void InvertRows(const Complex* rows, float* image);

 private:
  // Columns of a block and rows that are transformed together: 32 bytes of a row, half a line of
  // cache, while a block of 1500 rows takes 48 kB. Speed alone.
  static constexpr size_t kBlock = 4;
  // Copies the numbers of a row in a block: std::copy_n calls a function for them.
  static void CopyBlock(const Complex* from, Complex* to) {
    std::memcpy(to, from, kBlock * sizeof(Complex));
  }
  struct Plans;

  int width_ = 0, rows_ = 0;
  size_t blocks_ = 0;
  std::unique_ptr<Plans> plans_;
};

}  // namespace isthmus::matching
