// Rings of scans whose points do not name theirs.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scan.h"

namespace isthmus::floam {

// The origin of a sensor's beams, metres: above the origin of its points, and outwards from its
// axis. Ouster's are 36 and 16 to 28 mm off, which blurs elevations taken from the origin.
struct BeamOrigin {
  float up_m = 0, outwards_m = 0;

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.up_m, self.outwards_m);
  }
};

// Elevation of every point as seen from there, radians; azimuth likewise, in (-pi, pi].
void ComputeElevations(const Scan& scan, const BeamOrigin& origin, std::vector<float>* elevations);
void ComputeAzimuths(const Scan& scan, std::vector<float>* azimuths);

// The origin from which points gather most sharply at certain elevations; zero unless another is
// clearly better. Takes about 50 ms.
BeamOrigin FindBeamOrigin(const Scan& scan);

// Turns, counter-clockwise, that the azimuth makes in the order of points. Around 1 either way for
// points in order of firing, the number of rings for one ring after the other.
double CountTurns(const std::vector<float>& azimuths);

// For scans that hold one ring after the other (KITTI's HDL-64 files, Ouster's images): the azimuth
// at which rings begin, where elevation jumps from one ring to the next.
float FindSeam(const std::vector<float>& azimuths, const std::vector<float>& elevations);

// A new ring starts where the azimuth passes `seam` in the sense of `turns`, the signed number of
// turns in the order of points. Fills `*rings`; returns their number.
int RingsByWrap(const std::vector<float>& azimuths, double turns, float seam,
                std::vector<uint16_t>* rings);

// The elevations that the rings of a sensor have, from what its scans show. Scans add up: rings
// that look into the sky show only now and then.
class ElevationHistogram {
 public:
  ElevationHistogram();

  // Leaves out points that are near: sensors' lasers start a few centimetres apart.
  void Add(const Scan& scan, const std::vector<float>& elevations);
  // The elevations (radians, ascending) around which points gather; at most 256, empty when they do
  // not gather.
  std::vector<double> Peaks() const;
  // The chance that two points are within a tenth of a degree, but for a constant.
  double Sharpness() const;

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.counts_, self.total_);
    if constexpr (Io::kIsReading) {
      io.Expect(self.counts_.size() == ElevationHistogram().counts_.size());
    }
  }

 private:
  std::vector<double> PeaksOfWidth(int bins_per_peak) const;
  double Misfit(const std::vector<double>& elevations) const;

  std::vector<float> counts_;
  double total_ = 0;
};

// Gives every point the ring of nearest elevation. `rings_at` is ascending and not empty. Returns
// the mean distance to it in units of the spacing of the rings there: about 0.25 for points that
// know nothing of these rings, near 0 for points of this sensor.
double RingsByElevation(const std::vector<float>& elevations, const std::vector<double>& rings_at,
                        std::vector<uint16_t>* rings);

}  // namespace isthmus::floam
