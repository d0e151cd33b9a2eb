// Correlation of bird's-eye images over all shifts at once, by FFT.
#pragma once

#include <memory>
#include <vector>

#include "server/matching/search/birds_eye_image.h"

namespace isthmus::matching {

// Holds the spectra of one reference image. Not thread safe (buffers are reused); instances on
// different threads do not disturb each other.
class FftCorrelator {
 public:
  // Moved images may be `moved_size` cells wide and high at the most. `whiten`: frequencies that
  // the reference has much of count less, so that its scores are as if it resembled itself nowhere
  // but in place. Among placements in a world with the reference's statistics that is the matched
  // filter (Turin, "An introduction to matched filters", IRE Transactions 1960), but for the root:
  // whitened in full it follows the noise.
  FftCorrelator(const BirdsEyeImage& reference, int moved_size, bool whiten = false);
  ~FftCorrelator();

  // Side lengths of the field of scores.
  int width() const;
  int rows() const;
  // Most cells that a moved image may be wide and high.
  int moved_size() const;

  // The planes of the moved image: write into plane(k)[y * width() + x], x, y < moved_size().
  // They are zero after construction and after Correlate.
  float* plane(int k);

  // scores[y * width() + x]: the sum over planes and cells of moved(i, j) reference(i + x, j + y);
  // shifts below zero wrap round: x stands for x - width() where x >= reference width. Valid until
  // the next call.
  const float* Correlate();

 private:
  struct Buffers;
  void Whiten();

  std::unique_ptr<Buffers> buffers_;
};

}  // namespace isthmus::matching
