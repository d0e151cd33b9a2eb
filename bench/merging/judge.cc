#include "bench/merging/judge.h"

#include <algorithm>
#include <cstddef>
#include <numbers>

#include "bench/merging/figures.h"

namespace isthmus::bench {
namespace {

constexpr double kNearM = 20;  // Poses farther apart than this do not see the same.
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr size_t kGuesses = 30;  // Places at which the maps are made to fit.

}  // namespace

PairTruth::PairTruth(const DrivenRobot& a, const DrivenRobot& b) {
  same_ground_ = a.ground == b.ground;
  if (!same_ground_) return;
  const ScanPose &first_a = a.poses.front(), &first_b = b.poses.front();
  start_T_a_b_ = first_a.T_odom_sensor * first_a.T_world_sensor.Inverse() * first_b.T_world_sensor *
                 first_b.T_odom_sensor.Inverse();
  for (const ScanPose& at_b : b.poses) {
    const ScanPose* nearest = nullptr;
    double least = kNearM;
    for (const ScanPose& at_a : a.poses) {
      const double distance =
          (at_a.T_world_sensor.translation() - at_b.T_world_sensor.translation()).norm();
      if (distance >= least) continue;
      least = distance;
      nearest = &at_a;
    }
    if (nearest == nullptr) continue;
    near_.push_back({nearest->T_world_sensor.Inverse() * at_b.T_world_sensor,
                     nearest->T_odom_sensor, at_b.T_odom_sensor});
  }
  const size_t step = near_.size() / kGuesses + 1;
  for (size_t i = 0; i < near_.size(); i += step) {
    const NearPoses& poses = near_[i];
    const MapError error = ErrorOf(poses.T_odom_a * poses.T_a_b * poses.T_odom_b.Inverse());
    drift_.median_m = std::max(drift_.median_m, error.median_m);
    drift_.median_deg = std::max(drift_.median_deg, error.median_deg);
  }
}

MapError PairTruth::ErrorOf(const Pose& T_a_b) const {
  if (near_.empty()) return StartErrorOf(T_a_b);
  std::vector<double> metres, degrees;
  for (const NearPoses& poses : near_) {
    const Pose error = poses.T_a_b.Inverse() * (poses.T_odom_a.Inverse() * T_a_b * poses.T_odom_b);
    metres.push_back(error.translation().norm());
    degrees.push_back(RotationAngle(error) * kDegrees);
  }
  return {Median(metres), Median(degrees)};
}

MapError PairTruth::StartErrorOf(const Pose& T_a_b) const {
  const Pose error = start_T_a_b_.Inverse() * T_a_b;
  return {error.translation().norm(), RotationAngle(error) * kDegrees};
}

bool PairTruth::IsWithin(const Pose& T_a_b, double metres, double degrees) const {
  if (!same_ground_) return false;
  const MapError error = ErrorOf(T_a_b);
  return error.median_m <= drift_.median_m + metres &&
         error.median_deg <= drift_.median_deg + degrees;
}

MapError ErrorOfEdges(const DrivenRobot& a, const DrivenRobot& b,
                      const std::vector<SubmapEdge>& edges) {
  std::vector<double> metres, degrees;
  for (const SubmapEdge& edge : edges) {
    if (edge.submap_a >= a.submaps.size() || edge.submap_b >= b.submaps.size()) continue;
    const ScanPose* at_a = a.FindPose(a.submaps[edge.submap_a]->keyframes[0].sequence);
    const ScanPose* at_b = b.FindPose(b.submaps[edge.submap_b]->keyframes[0].sequence);
    if (at_a == nullptr || at_b == nullptr) continue;
    const Pose truth = at_a->T_world_sensor.Inverse() * at_b->T_world_sensor;
    const Pose error = truth.Inverse() * edge.T_a_b;
    metres.push_back(error.translation().norm());
    degrees.push_back(RotationAngle(error) * kDegrees);
  }
  return {Median(metres), Median(degrees)};
}

}  // namespace isthmus::bench
