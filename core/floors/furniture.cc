#include "core/floors/furniture.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/floors/limits.h"

namespace isthmus::floors {
namespace {

bool IsOpenAt(const Mask& mask, const Eigen::Vector2d& at) {
  return mask.IsOpen(static_cast<int64_t>(std::floor(at.x())),
                     static_cast<int64_t>(std::floor(at.y())));
}

// Cells of walls on the way from an end outwards.
double WallBeyond(const Mask& ground, const Mask& thick, const Eigen::Vector2d& from,
                  const Eigen::Vector2d& ahead, double reach) {
  constexpr double kStep = 0.5, kSlack = 3;  // Cells; ends lie beside a line that is turned.
  double at = 0, wall = 0;
  while (at < kSlack && IsOpenAt(ground, from + at * ahead)) at += kStep;
  for (; at < reach && !IsOpenAt(ground, from + at * ahead); at += kStep) {
    const Eigen::Vector2d place = from + at * ahead;
    const bool is_inside = (place.array() >= 0).all() &&
                           place.x() < static_cast<double>(ground.width) &&
                           place.y() < static_cast<double>(ground.height);
    if (is_inside && !IsOpenAt(thick, place)) wall += kStep;
  }
  return wall;
}

bool IsBeside(const Eigen::Vector2d& place, const Mask& mask) {
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      if (IsOpenAt(mask, place + Eigen::Vector2d(x, y))) return true;
    }
  }
  return false;
}

}  // namespace

bool IsBetweenFurniture(const Neck& neck, const Mask& ground, const Solids& solids,
                        double resolution_m) {
  constexpr double kTurn = 0.05;  // Ends lie anywhere in the thickness of a wall.
  constexpr int kTurns = 5;
  if (!IsBeside(neck.ends[0], solids.furniture) && !IsBeside(neck.ends[1], solids.furniture)) {
    return false;
  }
  const Eigen::Vector2d middle = (neck.ends[0] + neck.ends[1]) / 2, half = neck.ends[1] - middle;
  for (int turn = -kTurns; turn <= kTurns; ++turn) {
    const Eigen::Vector2d to = Eigen::Rotation2Dd(kTurn * turn) * half;
    double wall = 0;
    for (const Eigen::Vector2d& end : {to, Eigen::Vector2d(-to)}) {
      wall += WallBeyond(ground, solids.thick, middle + end, end.normalized(),
                         kWallReachM / resolution_m);
    }
    if (wall >= kLeastWallM / resolution_m) return false;
  }
  return true;
}

}  // namespace isthmus::floors
