#include "floam/track/recovery_guesses.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "floam/track/limits.h"
#include "floam/track/tracker.h"

namespace isthmus::floam {
namespace {

// Drives on at about the last speed or less along arcs of every curvature, the heading a little
// off. The farthest first: while they are looked at, the robot may drive on.
void AddArcs(const ScanPose& last, double elapsed_s, double reference_s,
             std::vector<ScanPose>* guesses) {
  const double time_s = std::min(elapsed_s, kMaxArcS);
  const double reach_m = last.twist.head<3>().norm() * time_s;
  const double reach_rad = std::min(kMaxArcRad, kGuessRadPerS * time_s);
  const Pose T_odom_last = last.At(0);
  for (double along = kArcReach * reach_m; along >= kGridM; along -= kGridM) {
    for (double turn = -reach_rad; turn <= reach_rad; turn += kArcStepRad) {
      Vector6d arc = Vector6d::Zero();
      arc.head<3>() = last.twist.head<3>() * (along / reach_m * time_s);
      arc[5] = turn;
      for (const double off : {-kGridRad, 0.0, kGridRad}) {
        const Pose T = T_odom_last * Exp(arc) * Pose::FromXyzRpy(0, 0, 0, 0, 0, off);
        guesses->push_back({T, last.twist, reference_s});
      }
    }
  }
}

// All places and headings nearby, however they were reached.
void AddGrid(const ScanPose& last, double elapsed_s, double reference_s,
             std::vector<ScanPose>* guesses) {
  const double speed = last.twist.head<3>().norm();
  const double reach_m = std::min(kMaxGridM, kGridM + speed * elapsed_s);
  const double reach_rad = std::min(std::numbers::pi, 2 * kGridRad + kGuessRadPerS * elapsed_s);
  const Pose T_odom_last = last.At(0);
  for (double x = -reach_m; x <= reach_m; x += kGridM) {
    for (double y = -reach_m; y <= reach_m; y += kGridM) {
      if (x * x + y * y > reach_m * reach_m) continue;
      for (double yaw = -reach_rad; yaw <= reach_rad; yaw += kGridRad) {
        const Eigen::Quaterniond turn(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
        const Pose T(turn * T_odom_last.rotation(),
                     T_odom_last.translation() + Eigen::Vector3d(x, y, 0));
        guesses->push_back({T, last.twist, reference_s});
      }
    }
  }
}

}  // namespace

std::vector<ScanPose> LikelyGuesses(const ScanPose& last, double elapsed_s, double reference_s) {
  std::vector<ScanPose> guesses;
  for (const double fraction : {1.0, 0.75, 0.5, 0.25, 0.0}) {
    ScanPose slowed = last;
    slowed.twist *= fraction;
    guesses.push_back(Predict(slowed, elapsed_s, reference_s));
    guesses.back().twist = last.twist;
  }
  return guesses;
}

std::vector<ScanPose> NearbyGuesses(const ScanPose& last, double elapsed_s, double reference_s) {
  std::vector<ScanPose> guesses;
  AddArcs(last, elapsed_s, reference_s, &guesses);
  AddGrid(last, elapsed_s, reference_s, &guesses);
  return guesses;
}

}  // namespace isthmus::floam
