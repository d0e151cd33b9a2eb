// FFTW's buffers and the lock of its planner, for correlations of real images.
#pragma once

#include <fftw3.h>

#include <algorithm>
#include <complex>
#include <cstddef>
#include <memory>

#include "core/concurrency/mutex.h"

namespace isthmus::matching {

// Held while a plan is made or destroyed: the one part of FFTW that threads must not share.
inline Mutex fftw_planner_mutex;

struct FreeFftw {
  void operator()(void* p) const { fftwf_free(p); }
};
using FftwComplex = std::complex<float>;
using RealBuffer = std::unique_ptr<float[], FreeFftw>;
using ComplexBuffer = std::unique_ptr<FftwComplex[], FreeFftw>;

inline RealBuffer MakeReal(size_t count) {
  RealBuffer buffer(static_cast<float*>(fftwf_malloc(count * sizeof(float))));
  std::fill_n(buffer.get(), count, 0.0f);
  return buffer;
}
inline ComplexBuffer MakeComplex(size_t count) {
  ComplexBuffer buffer(static_cast<FftwComplex*>(fftwf_malloc(count * sizeof(FftwComplex))));
  std::fill_n(buffer.get(), count, FftwComplex());
  return buffer;
}
inline fftwf_complex* Fftw(FftwComplex* numbers) {
  return reinterpret_cast<fftwf_complex*>(numbers);
}
inline fftwf_complex* Fftw(const ComplexBuffer& buffer) { return Fftw(buffer.get()); }

// Adds reference * conj(moved) * scale, bin by bin: FFTW does not normalise.
inline void AddCorrelation(const FftwComplex* reference, const FftwComplex* moved, size_t bins,
                           float scale, FftwComplex* product) {
  for (size_t i = 0; i < bins; ++i) {
    const float re = reference[i].real(), im = reference[i].imag();
    const float mr = moved[i].real() * scale, mi = moved[i].imag() * scale;
    product[i] += FftwComplex(re * mr + im * mi, im * mr - re * mi);
  }
}

}  // namespace isthmus::matching
