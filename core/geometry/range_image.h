// A range image of the space around a keyframe's sensor, coarse enough for sparse rings.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace isthmus {

// Ranges over direction in bins of 2 by 2 degrees, about the spacing of a sparse LiDAR's rings. A
// bin gives the shortest and the longest range measured in it AND its eight neighbours, so that at
// an edge of depth it claims no more than is true on both sides of the edge. Value type.
class RangeImage {
 public:
  static constexpr int kColumns = 180;  // Over azimuth.
  static constexpr int kRows = 46;      // Over elevation, +-46 degrees.
  static constexpr size_t kBins = size_t{kRows} * kColumns;

  RangeImage() = default;
  // `points` in the sensor frame.
  explicit RangeImage(const std::vector<Eigen::Vector3f>& points);

  struct Interval {
    float shortest = 0, longest = 0;  // Metres.
    // +1 for a range before all that was measured, -1 for one that was measured, within the margin;
    // 0 says nothing: it is hidden, or between the two.
    int Compare(float range, float margin) const {
      if (range < shortest - margin) return 1;
      return std::abs(range - shortest) < margin || std::abs(range - longest) < margin ? -1 : 0;
    }
  };
  // False where nothing was measured in the bin of that direction.
  bool At(const Eigen::Vector3f& direction, Interval* interval) const;

  // Row by row, centimetres, 0 for a bin without measurement; empty before anything was measured.
  const std::vector<uint16_t>& shortest_cm() const { return shortest_; }
  const std::vector<uint16_t>& longest_cm() const { return longest_; }
  // From what these gave; both have kBins bins.
  RangeImage(std::vector<uint16_t> shortest_cm, std::vector<uint16_t> longest_cm)
      : shortest_(std::move(shortest_cm)), longest_(std::move(longest_cm)) {}

 private:
  // Bin of a direction, -1 when outside of the rows.
  static int Bin(const Eigen::Vector3f& direction);

  // Centimetres; 0 marks a bin without measurement.
  std::vector<uint16_t> shortest_, longest_;
};

}  // namespace isthmus
