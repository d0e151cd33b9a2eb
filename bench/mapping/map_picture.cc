#include "bench/mapping/map_picture.h"

#include <cstdint>
#include <utility>

#include "bench/mapping/map_truth.h"
#include "client/evaluation/picture.h"

namespace isthmus::bench {
namespace {

constexpr size_t kOneIn = 4;     // Points that are drawn of those in submaps.
constexpr double kLowestM = -1;  // Below where the first sensor began: ground that is driven on.
constexpr size_t kChunk = 100'000;

evaluation::PictureOptions Style() {
  evaluation::PictureOptions options;
  options.min_z_m = kLowestM;
  return options;
}

std::vector<std::string> NamesOf(const std::vector<DrivenRobot>& robots) {
  std::vector<std::string> names;
  for (const DrivenRobot& robot : robots) names.push_back(robot.session.robot.value());
  return names;
}

absl::Status DrawOpen(const std::vector<DrivenRobot>& robots, const std::string& path) {
  std::vector<MapPoint> points;
  std::vector<Trajectory> ways;
  for (uint32_t r = 0; r < robots.size(); ++r) {
    ways.push_back(OdometryKeyframes(robots[r]));
    for (const auto& submap : robots[r].submaps) {
      for (size_t i = 0; i < submap->points.size(); i += kOneIn) {
        const Eigen::Vector3f p =
            (submap->T_odom_submap * submap->points[i].Position().cast<double>()).cast<float>();
        points.push_back({p.x(), p.y(), p.z(), submap->points[i].intensity, r});
      }
    }
  }
  return evaluation::WritePicture(path, points, ways, NamesOf(robots), Style());
}

absl::Status DrawClosed(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline,
                        const std::string& path) {
  std::vector<Trajectory> ways(robots.size());
  Region region;
  for (size_t r = 0; r < robots.size(); ++r) {
    auto way = pipeline.GetTrajectory(robots[r].session.robot, TrajectoryFrame::kMap);
    if (!way.ok()) return way.status();
    if (r == 0) region.component = way->component;
    if (way->component == region.component) ways[r] = std::move(way->poses);
  }
  std::vector<MapPoint> points;
  const auto add = [&](const std::vector<MapPoint>& chunk) {
    points.insert(points.end(), chunk.begin(), chunk.end());
    return true;
  };
  if (absl::Status status = pipeline.GetMap()->Read(region, kChunk, add); !status.ok()) {
    return status;
  }
  return evaluation::WritePicture(path, points, ways, NamesOf(robots), Style());
}

}  // namespace

absl::Status DrawOpenAndClosed(const std::vector<DrivenRobot>& robots, server::Pipeline& pipeline,
                               const std::string& path) {
  absl::Status status = DrawOpen(robots, path + "_open.png");
  if (status.ok()) status = DrawClosed(robots, pipeline, path + "_closed.png");
  return status;
}

}  // namespace isthmus::bench
