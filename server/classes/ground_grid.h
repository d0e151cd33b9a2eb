// The height of the ground, as it goes on from below the sensors.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace isthmus::classes {

// A square grid over a cloud, seen from above.
struct Layout {
  Eigen::Vector2f origin = Eigen::Vector2f::Zero();
  float edge_m = 0;
  int width = 0, height = 0;

  // Nothing of it is larger than memory allows, however far the points lie.
  static Layout Around(std::span<const Eigen::Vector3f> points);
  // The same place in cells of half the edge.
  Layout Halved() const { return {origin, edge_m / 2, 2 * width, 2 * height}; }
  size_t size() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
  size_t At(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
  }
  bool Has(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  // The cell of a point of the cloud.
  Eigen::Vector2i Find(const Eigen::Vector3f& p) const;
};

// Frame: z up. Immutable.
class GroundGrid {
 public:
  // `sensors`: places from which the points were seen. Where there are none the lowest point is on
  // the ground.
  GroundGrid(std::span<const Eigen::Vector3f> points, std::span<const Eigen::Vector3f> sensors);

  struct Cell {
    float lowest_m = 0;  // The lowest point; infinite where there is none, as the next two.
    // The lowest point of the cells up to one, up to three to either side.
    float lowest_near_m = 0, lowest_around_m = 0;
    float ground_m = 0;  // The ground's height.
    float sensor_m = 0;  // Height of the sensor from which the ground goes on to here.
    float steps = -1;    // Cells from there; negative until it is reached.
    float guessed = 0;   // Cells since ground was seen on the way from there.
  };
  const Layout& layout() const { return layout_; }
  const Cell& At(const Eigen::Vector3f& p) const;

 private:
  void LookAround();
  float LowestWithin(int x, int y, int cells) const;
  float SensorHeight(std::span<const Eigen::Vector3f> sensors) const;
  void Grow(std::span<const Eigen::Vector3f> sensors);

  Layout layout_;
  std::vector<Cell> cells_;
};

}  // namespace isthmus::classes
