#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/simulation/wild/furnish.h"

namespace isthmus::simulation::wild {
namespace {

Eigen::Matrix2d Turned(double yaw) { return Eigen::Rotation2Dd(yaw).toRotationMatrix(); }

// Half of the extent of a rectangle along an axis.
double Reach(const Eigen::Vector2d& half, const Eigen::Matrix2d& axes,
             const Eigen::Vector2d& axis) {
  return half.dot((axes.transpose() * axis).cwiseAbs());
}

}  // namespace

std::vector<Eigen::Vector3d> Trodden(const std::vector<std::shared_ptr<const Path>>& ways) {
  constexpr double kEvery = 0.2;
  std::vector<Eigen::Vector3d> points;
  for (const auto& way : ways) {
    for (double s = 0; s <= way->length(); s += kEvery) points.push_back(way->At(s).position);
  }
  return points;
}

Floor::Floor(const Eigen::Vector2d& min, const Eigen::Vector2d& max, double z, double clear_m,
             const std::vector<Eigen::Vector3d>& trodden)
    : min_(min), max_(max), z_(z), clear_m_(clear_m) {
  for (const Eigen::Vector3d& point : trodden) {
    const bool near = ((point.head<2>() - min).array() > -clear_m).all() &&
                      ((max - point.head<2>()).array() > -clear_m).all();
    if (near && std::abs(point.z() - z) < 1) trodden_.push_back(point.head<2>());
  }
}

bool Floor::Take(const Spot& spot, const Eigen::Vector2d& size) {
  const Taken wanted{spot.foot.head<2>(), size / 2, spot.yaw};
  const Eigen::Matrix2d axes = Turned(spot.yaw);
  for (int axis = 0; axis < 2; ++axis) {
    const double reach = Reach(wanted.half, axes, Eigen::Vector2d::Unit(axis));
    if (wanted.middle[axis] - reach < min_[axis] || wanted.middle[axis] + reach > max_[axis]) {
      return false;
    }
  }
  for (const Eigen::Vector2d& point : trodden_) {
    const Eigen::Vector2d local = axes.transpose() * (point - wanted.middle);
    if ((local.cwiseAbs() - wanted.half).cwiseMax(0).norm() < clear_m_) return false;
  }
  for (const Taken& other : taken_) {  // Apart along an axis of either.
    const Eigen::Matrix2d others = Turned(other.yaw);
    bool apart = false;
    for (int i = 0; i < 4 && !apart; ++i) {
      const Eigen::Vector2d axis = i < 2 ? axes.col(i) : others.col(i - 2);
      apart = std::abs(axis.dot(wanted.middle - other.middle)) >
              Reach(wanted.half, axes, axis) + Reach(other.half, others, axis);
    }
    if (!apart) return false;
  }
  taken_.push_back(wanted);
  return true;
}

std::optional<Spot> Floor::TakeAtWall(const Eigen::Vector2d& size, double gap_m, Random& random) {
  constexpr int kTries = 30;
  for (int i = 0; i < kTries; ++i) {
    const int side = random.Index(4);
    const double yaw = side * std::numbers::pi / 2, along = random.Unit();
    const double off = size.y() / 2 + gap_m, half = size.x() / 2;
    const Eigen::Vector2d room = Size();
    const auto on = [&](double length) { return half + along * (length - 2 * half); };
    const Eigen::Vector2d at = side == 0   ? Eigen::Vector2d(on(room.x()), off)
                               : side == 1 ? Eigen::Vector2d(room.x() - off, on(room.y()))
                               : side == 2 ? Eigen::Vector2d(on(room.x()), room.y() - off)
                                           : Eigen::Vector2d(off, on(room.y()));
    const double askew = random.Uniform(-1, 1) * gap_m / (half + size.y());
    const Spot spot{{min_.x() + at.x(), min_.y() + at.y(), z_}, yaw + askew};
    if (Take(spot, size)) return spot;
  }
  return std::nullopt;
}

std::optional<Spot> Floor::TakeAnywhere(const Eigen::Vector2d& size, Random& random) {
  constexpr int kTries = 30;
  for (int i = 0; i < kTries; ++i) {
    const double x = random.Uniform(min_.x(), max_.x()), y = random.Uniform(min_.y(), max_.y());
    const Spot spot{{x, y, z_}, random.Uniform(0, 2 * std::numbers::pi)};
    if (Take(spot, size)) return spot;
  }
  return std::nullopt;
}

}  // namespace isthmus::simulation::wild
