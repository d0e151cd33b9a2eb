// Grid maps drawn by hand.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/floors/grid_map.h"

namespace isthmus::floors {

// A map of which nothing is known, and rectangles drawn on it in metres, of a frame that is turned
// about the map's middle.
class DrawnFloor {
 public:
  DrawnFloor(double width_m, double height_m, double yaw = 0) : turn_(-yaw) {
    map_.resolution_m = 0.05;
    map_.origin = {-3, 7};
    map_.width = std::lround(width_m / map_.resolution_m);
    map_.height = std::lround(height_m / map_.resolution_m);
    map_.cells.assign(static_cast<size_t>(map_.width * map_.height), GridCell::kUnknown);
    middle_ = {width_m / 2, height_m / 2};
  }

  void Fill(double x0, double y0, double x1, double y1, GridCell cell) {
    for (int64_t y = 0; y < map_.height; ++y) {
      for (int64_t x = 0; x < map_.width; ++x) {
        const Eigen::Vector2d in_map(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
        const Eigen::Vector2d at = middle_ + turn_ * (map_.resolution_m * in_map - middle_);
        if (at.x() < x0 || at.x() >= x1 || at.y() < y0 || at.y() >= y1) continue;
        map_.cells[static_cast<size_t>(y * map_.width + x)] = cell;
      }
    }
  }
  // Free ground in walls of 0.15 m, outside of it.
  void Room(double x0, double y0, double x1, double y1) {
    constexpr double kWallM = 0.15;
    Fill(x0 - kWallM, y0 - kWallM, x1 + kWallM, y1 + kWallM, GridCell::kOccupied);
    Free(x0, y0, x1, y1);
  }
  void Free(double x0, double y0, double x1, double y1) { Fill(x0, y0, x1, y1, GridCell::kFree); }
  void Put(double x0, double y0, double x1, double y1) {
    Fill(x0, y0, x1, y1, GridCell::kOccupied);
  }
  // A place of the drawing in the map frame.
  Eigen::Vector2d InMap(double x, double y) const {
    return map_.origin + middle_ + turn_.inverse() * (Eigen::Vector2d(x, y) - middle_);
  }

  GridMap& map() { return map_; }
  const GridMap& map() const { return map_; }

 private:
  GridMap map_;
  Eigen::Vector2d middle_;
  Eigen::Rotation2Dd turn_;
};

}  // namespace isthmus::floors
