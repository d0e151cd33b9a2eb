// The way of a wild drive: an open curve that keeps its distance from everything in the world.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <unordered_map>
#include <vector>

#include "lab/simulation/random.h"

namespace isthmus::simulation::wild {

// Height of the ground, metres.
using HeightAt = std::function<double(const Eigen::Vector2d& at)>;

// A curve with continuous curvature: the uniform cubic B-spline of points about evenly spaced. In
// the plane of x and y it is run through by its length. Immutable but for Lay.
class Path {
 public:
  // Every point is `step_m` from the next, seen from above; four at least.
  Path(std::vector<Eigen::Vector3d> points, double step_m);

  // Along straight stretches from corner to corner, the corners rounded over about `round_m`; where
  // it goes back as it came, it turns within 0.3 m to either side.
  static Path Along(const std::vector<Eigen::Vector3d>& corners, double round_m);
  // Bends of about `wave_m` from left to right to left; never turned from the x axis by more than
  // `swing_rad`, so that with less than a right angle it does not cross itself, nor bent more
  // sharply than `radius_m`.
  struct Bends {
    double length_m = 0, wave_m = 0, swing_rad = 0, radius_m = 0;
  };
  static Path Wandering(const Bends& bends, Random& random);

  // From its end to its beginning.
  Path Backwards() const;
  // So much to the left of it, and above it.
  Path Moved(double left_m, double above_m) const;

  // Puts it on the ground, as what has wheels `base_m` apart, ahead and across, lies on it.
  void Lay(const HeightAt& height, double base_m);

  // Raises it by `by_m` between two places, with slopes of `slope_m` at both ends.
  void Raise(double from_m, double to_m, double by_m, double slope_m);

  struct Sample {
    Eigen::Vector3d position;
    double yaw = 0, pitch = 0, roll = 0;
    double curvature = 0;  // Signed, seen from above, 1/m.
  };
  // `s` in metres, clamped to the path.
  Sample At(double s) const;
  // `left_m` to the left of it, at the same height.
  Eigen::Vector3d Beside(double s, double left_m) const;
  double length() const { return step_m_ * static_cast<double>(points_.size() - 3); }
  double step_m() const { return step_m_; }
  const std::vector<Eigen::Vector3d>& points() const { return points_; }

 private:
  double step_m_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<double> roll_;
};

// Finds what is near a path, seen from above. Immutable.
class PathIndex {
 public:
  explicit PathIndex(const Path& path);

  struct Near {
    double distance_m = 0;  // `reach_m` if it is no nearer.
    double s = 0;           // Metres along the path, to within 0.3 m.
  };
  Near Nearest(const Eigen::Vector2d& at, double reach_m) const;
  double Distance(const Eigen::Vector2d& at, double reach_m) const {
    return Nearest(at, reach_m).distance_m;
  }
  // A place in the rectangle around the path and `reach_m` more to every side.
  Eigen::Vector2d Anywhere(double reach_m, Random& random) const;
  const Eigen::Vector2d& min() const { return min_; }
  const Eigen::Vector2d& max() const { return max_; }

 private:
  struct Entry {
    Eigen::Vector2d at;
    double s;
  };
  std::unordered_map<int64_t, std::vector<Entry>> cells_;
  Eigen::Vector2d min_, max_;
};

}  // namespace isthmus::simulation::wild
