#include "server/classes/features.h"

#include <Eigen/Geometry>
#include <cmath>

#include "server/classes/upright.h"

namespace isthmus::classes {
namespace {

std::vector<Eigen::Vector3f> Turned(std::span<const Eigen::Vector3f> points,
                                    const Eigen::Quaternionf& turn) {
  const Eigen::Matrix3f matrix = turn.toRotationMatrix();
  std::vector<Eigen::Vector3f> turned;
  turned.reserve(points.size());
  for (const Eigen::Vector3f& p : points) turned.emplace_back(matrix * p);
  return turned;
}

Eigen::Quaternionf LevelOf(std::span<const Eigen::Vector3f> points, const Eigen::Vector3f& up) {
  Moments moments(points);
  return Eigen::Quaternionf::FromTwoVectors(EstimateUp(&moments, up), Eigen::Vector3f::UnitZ());
}

}  // namespace

Surroundings::Surroundings(std::span<const Eigen::Vector3f> points,
                           std::span<const Eigen::Vector3f> sensors, const Eigen::Vector3f& up)
    : Surroundings(points, sensors, LevelOf(points, up)) {}

Surroundings::Surroundings(std::span<const Eigen::Vector3f> points,
                           std::span<const Eigen::Vector3f> sensors,
                           const Eigen::Quaternionf& level)
    : level_(Turned(points, level)),
      moments_(level_),
      ground_(level_, Turned(sensors, level)),
      columns_(level_, ground_) {}

float Surroundings::HeightOf(size_t i) const {
  return level_[i].z() - ground_.At(level_[i]).ground_m;
}

Features Surroundings::Of(size_t i) {
  const Eigen::Vector3f& p = level_[i];
  Features features;
  auto out = features.begin();
  for (int level = 0; level < kLevels; ++level) {
    const Shape shape = moments_.At(level, p);
    for (const float value : {shape.linear, shape.planar, shape.scattered, shape.normal_z,
                              shape.along_z, shape.thickness_m, shape.cells}) {
      *out++ = value;
    }
  }
  const GroundGrid::Cell& ground = ground_.At(p);
  const float height = p.z() - ground.ground_m;
  const Column& column = columns_.At(p);
  const Stretch run = columns_.StretchAt(p);
  const Course* course = columns_.CourseAt(p);
  const Course none;
  const Course& in = course != nullptr ? *course : none;
  for (const float value :
       {height, ground.guessed, std::log1p(ground.steps), p.z() - ground.sensor_m,
        p.z() - ground.lowest_near_m, p.z() - ground.lowest_around_m, run.bottom_m,
        run.top_m - height, run.bins, run.above, run.top_of_all_m - height,
        columns_.BesideAtHeight(p), column.beside, column.along, in.length_m, in.width_m,
        in.top_m}) {
    *out++ = value;
  }
  return features;
}

}  // namespace isthmus::classes
