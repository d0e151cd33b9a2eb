#include "core/geometry/shape.h"

#include <algorithm>
#include <array>
#include <utility>

namespace isthmus {
namespace {

std::array<Eigen::Vector3d, 8> CornersOf(const Box& box) {
  std::array<Eigen::Vector3d, 8> corners;
  for (unsigned i = 0; i < 8; ++i) {
    corners[i] = {(i & 1) != 0 ? box.max.x() : box.min.x(),
                  (i & 2) != 0 ? box.max.y() : box.min.y(),
                  (i & 4) != 0 ? box.max.z() : box.min.z()};
  }
  return corners;
}

// True if the line between the two, seen from above, meets the box.
bool MeetsBox(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Box& box) {
  double from = 0, to = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const double along = b[axis] - a[axis];
    double enter = box.min[axis] - a[axis], leave = box.max[axis] - a[axis];
    if (along == 0) {
      if (enter > 0 || leave < 0) return false;
      continue;
    }
    enter /= along;
    leave /= along;
    from = std::max(from, std::min(enter, leave));
    to = std::min(to, std::max(enter, leave));
  }
  // A little more than exact, as rounding must not make it less.
  return from <= to + 1e-9;
}

// True if p lies on the line from a to b: the cross product, zero on the line, gives p's side.
bool IsOnLine(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& p) {
  const Eigen::Vector2d u = b - a, v = p - a;
  if (u.x() * v.y() - u.y() * v.x() != 0) return false;
  const double along = u.dot(v);
  return along >= 0 && along <= u.squaredNorm();
}

}  // namespace

OrientedBoxShape::OrientedBoxShape(const Pose& T_map_box, const Eigen::Vector3d& size)
    : R_box_map_(T_map_box.RotationMatrix().transpose()),
      middle_(T_map_box.translation()),
      half_(size / 2) {
  for (const Eigen::Vector3d& corner : CornersOf(Box{-half_, half_})) {
    bounds_.Extend(T_map_box * corner);
  }
}

bool OrientedBoxShape::Contains(const Eigen::Vector3d& p) const {
  return ((R_box_map_ * (p - middle_)).array().abs() <= half_.array()).all();
}

bool OrientedBoxShape::ContainsAll(const Box& box) const {
  const auto corners = CornersOf(box);
  return std::all_of(corners.begin(), corners.end(),
                     [this](const Eigen::Vector3d& corner) { return Contains(corner); });
}

PolygonShape::PolygonShape(std::vector<Eigen::Vector2d> corners, const HeightBand& heights)
    : corners_(std::move(corners)), heights_(heights) {
  for (const Eigen::Vector2d& corner : corners_) {
    bounds_.Extend(Eigen::Vector3d(corner.x(), corner.y(), heights.min_m));
    bounds_.Extend(Eigen::Vector3d(corner.x(), corner.y(), heights.max_m));
  }
}

bool PolygonShape::Contains(const Eigen::Vector3d& p) const {
  if (!bounds_.Contains(p)) return false;
  const Eigen::Vector2d at = p.head<2>();
  bool inside = false;
  for (size_t i = 0, last = corners_.size() - 1; i < corners_.size(); last = i++) {
    const Eigen::Vector2d &a = corners_[last], &b = corners_[i];
    if (IsOnLine(a, b, at)) return true;
    if ((a.y() > at.y()) == (b.y() > at.y())) continue;
    if (at.x() < a.x() + (b.x() - a.x()) * (at.y() - a.y()) / (b.y() - a.y())) inside = !inside;
  }
  return inside;
}

bool PolygonShape::ContainsAll(const Box& box) const {
  if (!heights_.Contains(box.min.z()) || !heights_.Contains(box.max.z())) return false;
  // No line crosses it, so all of it is where one of its corners is.
  for (size_t i = 0, last = corners_.size() - 1; i < corners_.size(); last = i++) {
    if (MeetsBox(corners_[last], corners_[i], box)) return false;
  }
  return Contains(box.min);
}

CorridorShape::CorridorShape(std::vector<Eigen::Vector3d> path, double width_m,
                             const HeightBand& heights)
    : half_width_m_(width_m / 2), heights_(heights) {
  for (size_t i = 0; i == 0 || i + 1 < path.size(); ++i) {
    Piece piece;
    piece.from = path[i];
    piece.along = i + 1 < path.size() ? Eigen::Vector3d(path[i + 1] - path[i])
                                      : Eigen::Vector3d(Eigen::Vector3d::Zero());
    const double length2 = piece.along.head<2>().squaredNorm();
    piece.inverse_length2 = length2 > 0 ? 1 / length2 : 0;
    piece.bounds.Extend(piece.from);
    piece.bounds.Extend(piece.from + piece.along);
    piece.bounds.min += Eigen::Vector3d(-half_width_m_, -half_width_m_, heights.min_m);
    piece.bounds.max += Eigen::Vector3d(half_width_m_, half_width_m_, heights.max_m);
    pieces_.push_back(piece);
  }
}

bool CorridorShape::IsNear(const Piece& piece, const Eigen::Vector3d& p) const {
  const Eigen::Vector3d to = p - piece.from;
  const double share =
      std::clamp(to.head<2>().dot(piece.along.head<2>()) * piece.inverse_length2, 0.0, 1.0);
  const Eigen::Vector3d off = to - share * piece.along;
  return off.head<2>().squaredNorm() <= half_width_m_ * half_width_m_ && heights_.Contains(off.z());
}

bool CorridorShape::Contains(const Eigen::Vector3d& p) const {
  return std::any_of(pieces_.begin(), pieces_.end(),
                     [&](const Piece& piece) { return IsNear(piece, p); });
}

bool CorridorShape::MayTouch(const Box& box) const {
  return std::any_of(pieces_.begin(), pieces_.end(),
                     [&](const Piece& piece) { return piece.bounds.Intersects(box); });
}

bool CorridorShape::ContainsAll(const Box& box) const {
  const auto corners = CornersOf(box);
  // The surroundings of a level piece are convex: a piece that holds all corners of a box holds the
  // box. Around one that climbs the heights bend at its ends: point by point then.
  return std::any_of(pieces_.begin(), pieces_.end(), [&](const Piece& piece) {
    return piece.along.z() == 0 &&
           std::all_of(corners.begin(), corners.end(),
                       [&](const Eigen::Vector3d& corner) { return IsNear(piece, corner); });
  });
}

}  // namespace isthmus
