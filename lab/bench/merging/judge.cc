#include "lab/bench/merging/judge.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numbers>

#include "lab/bench/merging/figures.h"

namespace isthmus::bench {
namespace {

// Poses farther apart than this do not see the same. Robots that never come so near are judged
// where they are nearest: within so much more than the least distance.
constexpr double kNearM = 20;
constexpr double kNearestShare = 1.25;
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr size_t kGuesses = 30;  // Places at which the maps are made to fit.

}  // namespace

PairTruth::PairTruth(const DrivenRobot& a, const DrivenRobot& b) {
  same_ground_ = a.ground == b.ground;
  if (!same_ground_) return;
  const ScanPose &first_a = a.poses.front(), &first_b = b.poses.front();
  start_T_a_b_ = first_a.T_odom_sensor * first_a.T_world_sensor.Inverse() * first_b.T_world_sensor *
                 first_b.T_odom_sensor.Inverse();
  struct Meeting {
    double distance;
    const ScanPose *at_a, *at_b;
  };
  std::vector<Meeting> meetings;
  double least = std::numeric_limits<double>::max();
  for (const ScanPose& at_b : b.poses) {
    Meeting meeting{std::numeric_limits<double>::max(), nullptr, &at_b};
    for (const ScanPose& at_a : a.poses) {
      const double distance =
          (at_a.T_world_sensor.translation() - at_b.T_world_sensor.translation()).norm();
      if (distance < meeting.distance) meeting = {distance, &at_a, &at_b};
    }
    if (meeting.at_a == nullptr) continue;
    least = std::min(least, meeting.distance);
    meetings.push_back(meeting);
  }
  for (const Meeting& meeting : meetings) {
    if (meeting.distance > std::max(kNearM, kNearestShare * least)) continue;
    near_.push_back({meeting.at_a->T_world_sensor.Inverse() * meeting.at_b->T_world_sensor,
                     meeting.at_a->T_odom_sensor, meeting.at_b->T_odom_sensor});
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
