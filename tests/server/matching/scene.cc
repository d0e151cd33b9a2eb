#include "tests/server/matching/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <utility>

namespace isthmus::matching {
namespace {

constexpr int kRings = 24;
constexpr size_t kKeyframesPerSubmap = 5;

double CastBox(const SceneBox& box, const Eigen::Vector3d& origin,
               const Eigen::Vector3d& direction) {
  const Eigen::AngleAxisd to_box(-box.yaw, Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d o = to_box * (origin - box.center);
  const Eigen::Vector3d d = to_box * direction;
  double enter = 0, leave = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    double near = (-box.half_size[i] - o[i]) / d[i], far = (box.half_size[i] - o[i]) / d[i];
    if (near > far) std::swap(near, far);
    enter = std::max(enter, near);
    leave = std::min(leave, far);
  }
  return enter < leave && enter > 0 ? enter : -1;
}

}  // namespace

SceneBox Between(double x0, double y0, double z0, double x1, double y1, double z1) {
  const Eigen::Vector3d low(x0, y0, z0), high(x1, y1, z1);
  return {(low + high) / 2, (high - low) / 2};
}

double Scene::Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  double nearest = -1;
  for (const SceneBox& box : boxes) {
    const double range = CastBox(box, origin, direction);
    if (range > 0 && (nearest < 0 || range < nearest)) nearest = range;
  }
  return nearest;
}

Scene MakeGallery() {
  Scene scene;
  auto& boxes = scene.boxes;
  boxes.push_back(Between(-1, -1, -0.5, 31, 21, 0));  // Floor and ceiling.
  boxes.push_back(Between(-1, -1, 4, 31, 21, 4.5));
  boxes.push_back(Between(-0.5, -0.5, 0, 0, 20.5, 4));  // Outer walls.
  boxes.push_back(Between(30, -0.5, 0, 30.5, 20.5, 4));
  boxes.push_back(Between(0, -0.5, 0, 30, 0, 4));
  boxes.push_back(Between(0, 20, 0, 30, 20.5, 4));
  boxes.push_back(Between(12, 0, 0, 12.3, 5, 4));  // Inner walls, with doors left open.
  boxes.push_back(Between(12, 7, 0, 12.3, 12, 4));
  boxes.push_back(Between(0, 12, 0, 7, 12.3, 4));
  boxes.push_back(Between(9, 12, 0, 22, 12.3, 4));
  boxes.push_back(Between(25, 12, 0, 30, 12.3, 4));
  boxes.push_back(Between(20, 14.5, 0, 20.3, 20, 4));
  boxes.push_back({{5, 5, 0.6}, {1.0, 0.6, 0.6}, 0.4});  // Exhibits.
  boxes.push_back({{9, 9.5, 1.0}, {0.4, 0.4, 1.0}, 0.9});
  boxes.push_back({{17, 4, 0.5}, {1.5, 0.5, 0.5}, -0.3});
  boxes.push_back({{23, 8, 0.9}, {0.7, 0.7, 0.9}, 0.2});
  boxes.push_back({{26.5, 3, 1.2}, {0.3, 1.1, 1.2}, 0.6});
  boxes.push_back({{5, 16, 0.7}, {0.8, 1.6, 0.7}, 1.1});
  boxes.push_back({{15, 17, 1.1}, {0.5, 0.5, 1.1}, 0.5});
  boxes.push_back({{26, 17, 0.6}, {1.3, 0.4, 0.6}, -0.8});
  return scene;
}

std::vector<Eigen::Vector3d> Way(const std::vector<Eigen::Vector3d>& corners, int count) {
  std::vector<double> length = {0};
  for (size_t i = 1; i < corners.size(); ++i) {
    length.push_back(length.back() + (corners[i] - corners[i - 1]).norm());
  }
  std::vector<Eigen::Vector3d> positions;
  for (int k = 0; k < count; ++k) {
    const double s = length.back() * k / std::max(1, count - 1);
    size_t i = 1;
    while (i + 1 < length.size() && length[i] < s) ++i;
    const double f = (s - length[i - 1]) / (length[i] - length[i - 1]);
    positions.push_back(corners[i - 1] + f * (corners[i] - corners[i - 1]));
  }
  return positions;
}

MatcherOptions InTheGallery() {
  MatcherOptions options;
  options.min_probability = 0.05;
  return options;
}

SessionMap Survey(const Scene& scene, const Drive& drive) {
  SessionMap map;
  map.session = SessionId("survey-" + std::to_string(drive.seed));
  std::mt19937 rng(drive.seed);
  std::normal_distribution<double> noise(0, drive.noise_m);
  const Pose T_odom_world = drive.T_world_odom.Inverse();
  std::shared_ptr<Submap> submap;
  for (size_t k = 0; k < drive.positions.size(); ++k) {
    const Pose T_odom_sensor = T_odom_world * Pose(drive.positions[k]);
    if (k % kKeyframesPerSubmap == 0) {
      submap = std::make_shared<Submap>();
      submap->id = {map.session, static_cast<uint32_t>(map.submaps.size())};
      submap->T_odom_submap = T_odom_sensor;
      map.submaps.push_back(submap);
    }
    const Pose T_submap_odom = submap->T_odom_submap.Inverse();
    submap->keyframes.push_back({k + 1, static_cast<int64_t>(k), T_submap_odom * T_odom_sensor});
    for (int ring = 0; ring < kRings; ++ring) {
      const double elevation = (-40.0 + 80.0 * ring / (kRings - 1)) * M_PI / 180;
      for (int i = 0; i < drive.azimuths; ++i) {
        // Each turn starts elsewhere, as real ones do.
        const double azimuth = 2 * M_PI * (i + 0.37 * static_cast<double>(k)) / drive.azimuths;
        const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                        std::cos(elevation) * std::sin(azimuth),
                                        std::sin(elevation));
        const double range = scene.Cast(drive.positions[k], direction);
        if (range < 0 || range > drive.max_range_m) continue;
        const Eigen::Vector3d p_world = drive.positions[k] + direction * (range + noise(rng));
        const Eigen::Vector3f p = (T_submap_odom * (T_odom_world * p_world)).cast<float>();
        submap->points.push_back(
            {p.x(), p.y(), p.z(), 1.0f, static_cast<uint16_t>(submap->keyframes.size() - 1)});
      }
    }
  }
  return map;
}

std::vector<std::shared_ptr<const Submap>> Stray(
    const std::vector<std::shared_ptr<const Submap>>& truth, const Pose& step) {
  std::vector<std::shared_ptr<const Submap>> strayed;
  Pose T_odom_before, T_true_before;
  for (const auto& submap : truth) {
    auto moved = std::make_shared<Submap>(*submap);
    if (!strayed.empty()) {
      moved->T_odom_submap = T_odom_before * T_true_before.Inverse() * submap->T_odom_submap * step;
    }
    T_odom_before = moved->T_odom_submap;
    T_true_before = submap->T_odom_submap;
    strayed.push_back(std::move(moved));
  }
  return strayed;
}

}  // namespace isthmus::matching
