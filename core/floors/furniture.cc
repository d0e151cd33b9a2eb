#include "core/floors/furniture.h"

#include <Eigen/Geometry>
#include <algorithm>
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

// Cells from a place on solid ground to the open on one side; `most` if it is farther.
double Depth(const Mask& ground, const Eigen::Vector2d& from, const Eigen::Vector2d& ahead,
             double most) {
  constexpr double kStep = 0.5;
  double at = 0;
  while (at < most && !IsOpenAt(ground, from + at * ahead)) at += kStep;
  return at;
}

// True if what lies beyond both ends of a line across a neck is one wall: it begins and ends on
// either side as far from the line, and is no thicker than thick walls.
bool IsOneWall(const Mask& ground, const Eigen::Vector2d& middle, const Eigen::Vector2d& half,
               double resolution_m) {
  constexpr double kAlike = 2;  // Cells.
  const double most = kThickestLongWallM / resolution_m;
  const Eigen::Vector2d along = half.normalized(), across(-along.y(), along.x());
  const Eigen::Vector2d off = half + kWallBesideM / resolution_m * along;
  double thickness = 0;
  for (const Eigen::Vector2d& side : {across, Eigen::Vector2d(-across)}) {
    const double left = Depth(ground, middle + off, side, most);
    const double right = Depth(ground, middle - off, side, most);
    if (left == 0 || right == 0 || std::abs(left - right) > kAlike) return false;
    thickness += std::max(left, right);
  }
  return thickness <= most;
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
    if (IsOneWall(ground, middle, to, resolution_m)) return false;
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
