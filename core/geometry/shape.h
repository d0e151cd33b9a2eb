// Solids that the parts of a map are cut out by: boxes that stand askew, prisms, corridors.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "core/cloud.h"
#include "core/pose.h"

namespace isthmus {

// Immutable; safe to read from many threads. Points on the surface are inside.
class Shape {
 public:
  virtual ~Shape() = default;
  virtual bool Contains(const Eigen::Vector3d& p) const = 0;
  // False only if no point of the box is inside.
  virtual bool MayTouch(const Box& box) const = 0;
  // True only if all points of the box are inside.
  virtual bool ContainsAll(const Box& box) const = 0;
};

// Open where it is not finite.
struct HeightBand {
  double min_m = -std::numeric_limits<double>::infinity();
  double max_m = std::numeric_limits<double>::infinity();

  bool Contains(double height) const { return height >= min_m && height <= max_m; }
};

// A box that stands askew.
class OrientedBoxShape final : public Shape {
 public:
  // `T_map_box` is that of its middle; `size` are whole edges.
  OrientedBoxShape(const Pose& T_map_box, const Eigen::Vector3d& size);

  bool Contains(const Eigen::Vector3d& p) const override;
  bool MayTouch(const Box& box) const override { return bounds_.Intersects(box); }
  bool ContainsAll(const Box& box) const override;

 private:
  const Eigen::Matrix3d R_box_map_;
  const Eigen::Vector3d middle_, half_;
  Box bounds_;
};

// An upright prism over a polygon, whose last corner is joined with the first. If its lines cross,
// points surrounded an odd number of times are inside.
class PolygonShape final : public Shape {
 public:
  // Heights are the map's.
  PolygonShape(std::vector<Eigen::Vector2d> corners, const HeightBand& heights);

  bool Contains(const Eigen::Vector3d& p) const override;
  bool MayTouch(const Box& box) const override { return bounds_.Intersects(box); }
  bool ContainsAll(const Box& box) const override;

 private:
  const std::vector<Eigen::Vector2d> corners_;
  const HeightBand heights_;
  Box bounds_;
};

// The surroundings of a path: seen from above at most half the width from one of its pieces, and as
// high above that piece's nearest place as the band says.
class CorridorShape final : public Shape {
 public:
  // A path of one point is an upright cylinder.
  CorridorShape(std::vector<Eigen::Vector3d> path, double width_m, const HeightBand& heights);

  bool Contains(const Eigen::Vector3d& p) const override;
  bool MayTouch(const Box& box) const override;
  bool ContainsAll(const Box& box) const override;

 private:
  struct Piece {
    Eigen::Vector3d from, along;
    double inverse_length2 = 0;  // Seen from above; 0 for a piece without any.
    Box bounds;
  };
  bool IsNear(const Piece& piece, const Eigen::Vector3d& p) const;

  const double half_width_m_;
  const HeightBand heights_;
  std::vector<Piece> pieces_;
};

}  // namespace isthmus
