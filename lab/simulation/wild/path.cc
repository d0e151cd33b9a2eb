#include "lab/simulation/wild/path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isthmus::simulation::wild {
namespace {

// Weights of four neighbouring points at `t` between the middle two, and their derivatives.
struct Weights {
  double at[4], slope[4], bend[4];

  explicit Weights(double t) {
    const double r = 1 - t;
    const double values[] = {r * r * r / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
                             (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
    const double slopes[] = {-r * r / 2, (3 * t * t - 4 * t) / 2, (-3 * t * t + 2 * t + 1) / 2,
                             t * t / 2};
    const double bends[] = {r, 3 * t - 2, 1 - 3 * t, t};
    for (int i = 0; i < 4; ++i) {
      at[i] = values[i];
      slope[i] = slopes[i];
      bend[i] = bends[i];
    }
  }
};

// Points on the straight stretches, about `spacing_m` apart.
std::vector<Eigen::Vector3d> Spaced(const std::vector<Eigen::Vector3d>& corners, double spacing_m) {
  std::vector<Eigen::Vector3d> points;
  for (size_t i = 0; i + 1 < corners.size(); ++i) {
    const Eigen::Vector3d by = corners[i + 1] - corners[i];
    const int count = std::max(1, static_cast<int>(std::lround(by.norm() / spacing_m)));
    for (int k = 0; k < count; ++k) points.push_back(corners[i] + by * k / count);
  }
  points.push_back(corners.back());
  return points;
}

// Turns where the way goes back as it came, which would be a turn in no time.
void TurnBetween(std::vector<Eigen::Vector3d>* points, double spacing_m) {
  constexpr double kBack = -0.9;  // Cosine: turned by more than 154 degrees.
  const double half = std::min(0.3, spacing_m / 2);
  for (size_t i = 1; i + 1 < points->size(); ++i) {
    const Eigen::Vector3d at = (*points)[i];
    const auto behind = points->begin() + static_cast<std::ptrdiff_t>(i) + 1;
    const auto next = std::find_if(behind, points->end(), [&](const auto& p) { return p != at; });
    if (next == points->end()) return;
    const Eigen::Vector2d in = (at - (*points)[i - 1]).head<2>().normalized();
    const Eigen::Vector2d out = (*next - at).head<2>().normalized();
    if (in.dot(out) > kBack) continue;
    const bool to_left = in.x() * out.y() - in.y() * out.x() > 0;
    const Eigen::Vector2d side = (to_left ? half : -half) * Eigen::Vector2d(in.y(), -in.x());
    const Eigen::Vector3d aside(side.x(), side.y(), 0);
    (*points)[i] = at + aside;
    points->insert(points->erase(behind, next), at - aside);
    ++i;
  }
}

// The same curve by points at even steps, seen from above.
std::vector<Eigen::Vector3d> Resampled(const std::vector<Eigen::Vector3d>& dense, double step_m) {
  std::vector<Eigen::Vector3d> points{dense[0]};
  double since = 0;
  for (size_t i = 1; i < dense.size(); ++i) {
    const Eigen::Vector3d by = dense[i] - dense[i - 1];
    const double length = by.head<2>().norm();
    double at = step_m - since;
    for (; at <= length; at += step_m) points.push_back(dense[i - 1] + by * at / length);
    since = length - (at - step_m);
  }
  return points;
}

}  // namespace

Path::Path(std::vector<Eigen::Vector3d> points, double step_m)
    : step_m_(step_m), points_(std::move(points)), roll_(points_.size(), 0.0) {}

Path Path::Along(const std::vector<Eigen::Vector3d>& corners, double round_m) {
  constexpr double kStep = 0.1;
  std::vector<Eigen::Vector3d> control = Spaced(corners, round_m);
  TurnBetween(&control, round_m);
  std::vector<Eigen::Vector3d> dense;
  const auto fine = static_cast<int>(std::ceil(round_m / 0.02));
  for (size_t i = 0; i + 3 < control.size(); ++i) {
    for (int k = 0; k < fine; ++k) {
      const Weights weights(static_cast<double>(k) / fine);
      Eigen::Vector3d at = Eigen::Vector3d::Zero();
      for (int j = 0; j < 4; ++j) at += weights.at[j] * control[i + j];
      dense.push_back(at);
    }
  }
  return Path(Resampled(dense, kStep), kStep);
}

Path Path::Wandering(const Bends& bends, Random& random) {
  constexpr double kStep = 0.25;
  constexpr int kWaves = 4;
  double per_m[kWaves], phase[kWaves], share[kWaves], sum = 0, bend = 0;
  for (int i = 0; i < kWaves; ++i) {
    per_m[i] = 2 * std::numbers::pi / (bends.wave_m * random.Uniform(0.5, 2.5));
    phase[i] = random.Uniform(0, 2 * std::numbers::pi);
    share[i] = random.Uniform(0.2, 1);
    sum += share[i];
  }
  for (int i = 0; i < kWaves; ++i) bend += bends.swing_rad * share[i] / sum * per_m[i];
  const double gentler = std::min(1.0, 1 / (bends.radius_m * bend));
  std::vector<Eigen::Vector3d> points{Eigen::Vector3d::Zero()};
  const auto count = static_cast<size_t>(bends.length_m / kStep) + 4;
  while (points.size() < count) {
    const double s = static_cast<double>(points.size()) * kStep;
    double heading = 0;
    for (int i = 0; i < kWaves; ++i) {
      heading += gentler * bends.swing_rad * share[i] / sum * std::sin(per_m[i] * s + phase[i]);
    }
    points.push_back(points.back() +
                     kStep * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0));
  }
  return Path(std::move(points), kStep);
}

Path Path::Backwards() const {
  Path path = *this;
  std::reverse(path.points_.begin(), path.points_.end());
  std::reverse(path.roll_.begin(), path.roll_.end());
  for (double& roll : path.roll_) roll = -roll;
  return path;
}

Path Path::Moved(double left_m, double above_m) const {
  Path path = *this;
  for (size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector3d ahead =
        points_[std::min(i + 1, points_.size() - 1)] - points_[std::max<size_t>(i, 1) - 1];
    const Eigen::Vector2d left = Eigen::Vector2d(-ahead.y(), ahead.x()).normalized();
    path.points_[i] += Eigen::Vector3d(left_m * left.x(), left_m * left.y(), above_m);
  }
  return path;
}

void Path::Lay(const HeightAt& height, double base_m) {
  const size_t count = points_.size();
  std::vector<double> left(count), right(count);
  for (size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d ahead =
        points_[std::min(i + 1, count - 1)] - points_[std::max<size_t>(i, 1) - 1];
    const Eigen::Vector2d across =
        Eigen::Vector2d(-ahead.y(), ahead.x()).normalized() * (base_m / 2);
    left[i] = height(points_[i].head<2>() + across);
    right[i] = height(points_[i].head<2>() - across);
  }
  const auto reach = static_cast<size_t>(std::lround(base_m / 2 / step_m_));
  for (size_t i = 0; i < count; ++i) {
    const size_t from = i - std::min(i, reach), to = std::min(i + reach, count - 1);
    double l = 0, r = 0;
    for (size_t k = from; k <= to; ++k) {
      l += left[k];
      r += right[k];
    }
    const auto wheels = static_cast<double>(to - from + 1);
    points_[i].z() = (l + r) / (2 * wheels);
    roll_[i] = std::atan((l - r) / wheels / base_m);
  }
}

void Path::Raise(double from_m, double to_m, double by_m, double slope_m) {
  const auto eased = [](double t) {
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3 - 2 * t);
  };
  for (size_t i = 0; i < points_.size(); ++i) {
    const double s = step_m_ * (static_cast<double>(i) - 1);
    points_[i].z() +=
        by_m * (eased((s - from_m) / slope_m) - eased((s - to_m + slope_m) / slope_m));
  }
}

Path::Sample Path::At(double s) const {
  const double u = std::clamp(s, 0.0, length()) / step_m_;
  const size_t i = std::min(static_cast<size_t>(u), points_.size() - 4);
  const Weights weights(u - static_cast<double>(i));
  Eigen::Vector3d d1 = Eigen::Vector3d::Zero(), d2 = Eigen::Vector3d::Zero();
  Sample sample;
  sample.position.setZero();
  for (int k = 0; k < 4; ++k) {
    sample.position += weights.at[k] * points_[i + k];
    d1 += weights.slope[k] * points_[i + k];
    d2 += weights.bend[k] * points_[i + k];
    sample.roll += weights.at[k] * roll_[i + k];
  }
  const double level = std::max(d1.head<2>().norm(), 1e-9);
  sample.yaw = std::atan2(d1.y(), d1.x());
  sample.pitch = -std::atan2(d1.z(), level);
  sample.curvature = (d1.x() * d2.y() - d1.y() * d2.x()) / (level * level * level);
  return sample;
}

Eigen::Vector3d Path::Beside(double s, double left_m) const {
  const Sample at = At(s);
  return at.position + left_m * Eigen::Vector3d(-std::sin(at.yaw), std::cos(at.yaw), 0);
}

}  // namespace isthmus::simulation::wild
