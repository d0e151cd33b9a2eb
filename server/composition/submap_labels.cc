#include "server/composition/submap_labels.h"

#include <Eigen/Core>
#include <cmath>

#include "server/classes/classify.h"

namespace isthmus::composition {
namespace {

// Odom's z, submap frame. Up is near it however the sensor is mounted, as far as is known here.
Eigen::Vector3f UpIn(const Submap& submap) {
  const Eigen::Vector3d up = submap.T_odom_submap.rotation().inverse() * Eigen::Vector3d::UnitZ();
  return up.allFinite() ? up.cast<float>() : Eigen::Vector3f(0, 0, 1);
}

std::vector<Eigen::Vector3f> SensorsOf(const Submap& submap) {
  std::vector<Eigen::Vector3f> sensors;
  for (const Keyframe& keyframe : submap.keyframes) {
    const Eigen::Vector3f at = keyframe.T_submap_sensor.translation().cast<float>();
    if (at.allFinite()) sensors.push_back(at);
  }
  return sensors;
}

}  // namespace

bool LabelPoints(const Submap& submap, const KeepOn& keep_on, std::vector<WeightedPoint>* points) {
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(points->size());
  for (const WeightedPoint& p : *points) positions.emplace_back(p.x, p.y, p.z);
  const auto ends_at = [&keep_on](size_t i) { return EndsAt(i, keep_on); };
  const auto labels = classes::Classify(positions, SensorsOf(submap), UpIn(submap),
                                        classes::Forest::Own(), ends_at);
  if (!labels) return false;
  for (size_t i = 0; i < points->size(); ++i) {
    (*points)[i].label = static_cast<uint8_t>((*labels)[i].likeliest);
    (*points)[i].certainty = static_cast<uint8_t>(std::lround(255 * (*labels)[i].probability));
  }
  return true;
}

}  // namespace isthmus::composition
