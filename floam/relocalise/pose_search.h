// A search for the place and heading at which a scan fits a picture of the map: correlative scan
// matching by branch and bound.
//
// E. Olson, "Real-Time Correlative Scan Matching", ICRA 2009; W. Hess, D. Kohler, H. Rapp,
// D. Andor, "Real-Time Loop Closure in 2D LIDAR SLAM", ICRA 2016, section V.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "floam/map/wall_image.h"

namespace isthmus::floam {

struct PoseSearchOptions {
  double min_score = 0.45;          // Worse is not worth a closer look; [-0.5, 1].
  double min_of_best = 0.7;         // Nor is what scores less than this share of the best.
  int max_found = 6;                // Poses that are returned.
  double apart_m = 1.5;             // Two poses are different if they are this far apart ...
  double apart_rad = 0.25;          // ... or so much turned.
  size_t max_lookups = 60'000'000;  // Cells looked up, about 1 ns each; the search gives up beyond.
};

// A place and a heading of the sensor.
struct FoundPose {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // Odom.
  double yaw = 0;
  double score = 0;  // Mean worth of the scan's walls there, in units of WallImage::kWall.
};

struct PoseSearchResult {
  std::vector<FoundPose> found;  // Best first.
  size_t lookups = 0;
  bool complete = false;  // Nothing else is good enough, or max_found were found.
};

// Level h holds in each cell the largest value of the 2^h x 2^h cells of which it is the low corner
// (the image's own values on level 0). Cells outside count as unknown.
class MaxPyramid {
 public:
  MaxPyramid(const WallImage& image, int levels);
  int levels() const { return static_cast<int>(levels_.size()); }
  int width() const { return width_; }
  const int8_t* Level(int level) const { return levels_[level].data(); }

 private:
  int width_;
  std::vector<std::vector<int8_t>> levels_;
};

// `walls` are horizontal coordinates about the sensor (ScanImage::Walls), nearer than the image's
// margin. Exhaustive: every cell in which the sensor may be with every heading, steps of
// HeadingStep; the best one found is the best there is.
PoseSearchResult SearchPoses(const WallImage& image, const std::vector<Eigen::Vector2f>& walls,
                             const PoseSearchOptions& options);

// Turns the farthest wall by one cell, radians.
double HeadingStep(const std::vector<Eigen::Vector2f>& walls);

// Cells by which the walls lie off the sensor's cell at a heading.
std::vector<Eigen::Vector2i> WallOffsets(const std::vector<Eigen::Vector2f>& walls, double yaw);

}  // namespace isthmus::floam
