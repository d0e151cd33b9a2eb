// A scan as a picture: rings by columns of azimuth.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "floam/rings/ring_scan.h"

namespace isthmus::floam {

// Counts of walls that were there before.
struct WallsSeen {
  int onto = 0;     // Walls that the scan sees in their places.
  int through = 0;  // Walls that it looks through: they are not there.

  int count() const { return onto + through; }
  double through_share() const { return count() > 0 ? static_cast<double>(through) / count() : 1; }
};

// The scan is taken as it was measured: the sensor hardly moved meanwhile. Not thread safe.
class ScanImage {
 public:
  static constexpr int kColumns = 360;

  // Replaces the contents.
  void Make(const RingScan& scan);

  // Upright things that two neighbouring rings saw one above the other, horizontal coordinates
  // about the sensor after `R_level_sensor`, metres; one per square of `spacing_m`, none farther
  // than `max_range_m`.
  std::vector<Eigen::Vector2f> Walls(const Eigen::Matrix3f& R_level_sensor, float spacing_m,
                                     float max_range_m) const;

  enum class Sight {
    kUnknown,  // No ring looked there, or it got no answer.
    kThrough,  // The sensor looked through the point: it saw something farther away.
    kOnto,     // It saw something where the point is.
    kHidden,   // It saw something nearer.
  };
  // The scan's evidence about a point in the sensor frame.
  Sight SightOf(const Eigen::Vector3f& point) const;

 private:
  struct Pixel {
    Eigen::Vector3f nearest = Eigen::Vector3f::Zero();
    float min_range = 0, max_range = 0;  // Zero: nothing was seen.
  };
  const Pixel& At(size_t ring, int column) const { return pixels_[ring * kColumns + column]; }

  std::vector<Pixel> pixels_;
  std::vector<float> elevations_;  // Rings that saw something, radians, ascending.
};

}  // namespace isthmus::floam
