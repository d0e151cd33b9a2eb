#include "server/placement/corrected_trajectory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace isthmus::placement {
namespace {

constexpr int kPerSubmap = 20;
constexpr int kEntries = 200;

// A winding drive, ten scans a second, a submap every 20; standing still for a while.
class CorrectedTrajectory : public testing::Test {
 protected:
  CorrectedTrajectory() {
    Pose pose;
    for (int i = 0; i < kEntries; ++i) {
      TrajectoryEntry entry;
      entry.sequence = static_cast<uint64_t>(i) + 1;
      entry.stamp_ns = 1'000'000'000 + i * 100'000'000ll;
      entry.T_odom_sensor = pose;
      entry.submap_index = static_cast<uint32_t>(i / kPerSubmap);
      entries_.push_back(entry);
      if (i % kPerSubmap == 0) knots_.push_back({entry.submap_index, entry.stamp_ns, pose});
      const bool stands = i >= 60 && i < 95;
      if (!stands) pose = pose * Pose::FromXyzRpy(0.2, 0, 0, 0, 0, 0.05 * std::sin(0.1 * i));
    }
    placement_.session = SessionId("a-1");
    for (const TrajectoryKnot& knot : knots_) {
      placement_.submaps.push_back({knot.index, knot.T_odom_submap});
    }
  }

  void Bend(double position_m, double rotation_rad) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (SubmapPose& submap : placement_.submaps) {
      Vector6d twist;
      for (int i = 0; i < 6; ++i) twist[i] = (i < 3 ? position_m : rotation_rad) * normal(random);
      submap.T_map_submap = submap.T_map_submap * Exp(twist);
    }
    placement_.T_map_odom =
        placement_.submaps.back().T_map_submap * knots_.back().T_odom_submap.Inverse();
  }

  std::vector<TrajectoryEntry> entries_;
  std::vector<TrajectoryKnot> knots_;
  Placement placement_;
};

TEST_F(CorrectedTrajectory, IsRigidWhereNothingBent) {
  const Pose T = Pose::FromXyzRpy(3, -4, 1, 0.1, 0.2, 2);
  for (SubmapPose& submap : placement_.submaps) submap.T_map_submap = T * submap.T_map_submap;
  const Trajectory trajectory = CorrectTrajectory(entries_, knots_, placement_);
  ASSERT_EQ(trajectory.size(), entries_.size());
  for (size_t i = 0; i < entries_.size(); ++i) {
    EXPECT_EQ(trajectory[i].stamp_ns, entries_[i].stamp_ns);
    EXPECT_LT(Log(trajectory[i].pose.Inverse() * T * entries_[i].T_odom_sensor).norm(), 1e-9);
  }
}

TEST_F(CorrectedTrajectory, PassesThroughTheSubmaps) {
  Bend(0.5, 0.1);
  const Trajectory trajectory = CorrectTrajectory(entries_, knots_, placement_);
  for (size_t k = 0; k < knots_.size(); ++k) {
    const Pose gap = trajectory[k * kPerSubmap].pose.Inverse() * placement_.submaps[k].T_map_submap;
    EXPECT_LT(Log(gap).norm(), 1e-9) << k;
  }
}

// From scan to scan it goes as the odometry does, and by no more than its share of the bend.
TEST_F(CorrectedTrajectory, IsContinuous) {
  Bend(0.3, 0.05);
  const Trajectory trajectory = CorrectTrajectory(entries_, knots_, placement_);
  for (size_t i = 1; i < entries_.size(); ++i) {
    const Pose odom = entries_[i - 1].T_odom_sensor.Inverse() * entries_[i].T_odom_sensor;
    const Pose map = trajectory[i - 1].pose.Inverse() * trajectory[i].pose;
    const size_t k = (i - 1) / kPerSubmap;
    double position_m = 0, rotation_rad = 0;
    if (k + 1 < knots_.size()) {
      const Pose bend =
          (placement_.submaps[k].T_map_submap.Inverse() * placement_.submaps[k + 1].T_map_submap)
              .Inverse() *
          (knots_[k].T_odom_submap.Inverse() * knots_[k + 1].T_odom_submap);
      // A turn moves what is far from where it happens: at most the length of a submap.
      rotation_rad = RotationAngle(bend);
      position_m = bend.translation().norm() + rotation_rad * 0.2 * kPerSubmap;
      double path_length = 0;
      for (size_t j = k * kPerSubmap + 1; j <= (k + 1) * kPerSubmap; ++j) {
        path_length +=
            (entries_[j].T_odom_sensor.translation() - entries_[j - 1].T_odom_sensor.translation())
                .norm();
      }
      const double step = odom.translation().norm();
      const double share = path_length > 0 ? step / path_length : 1.0 / kPerSubmap;
      position_m = share * position_m + rotation_rad * step;
      rotation_rad *= share;
    }
    EXPECT_LT((odom.translation() - map.translation()).norm(), position_m + 1e-9) << i;
    EXPECT_LT(RotationAngle(odom.Inverse() * map), rotation_rad + 1e-9) << i;
  }
}

TEST_F(CorrectedTrajectory, PassesOverRetiredSubmaps) {
  Bend(0.3, 0.05);
  std::erase_if(placement_.submaps, [](const SubmapPose& submap) {
    return submap.index == 0 || submap.index == 4 || submap.index == 9;
  });
  const Trajectory trajectory = CorrectTrajectory(entries_, knots_, placement_);
  ASSERT_EQ(trajectory.size(), entries_.size());
  // Before the first as that one says, behind the last likewise.
  const Pose first = placement_.submaps.front().T_map_submap * knots_[1].T_odom_submap.Inverse();
  EXPECT_LT(Log(trajectory[0].pose.Inverse() * first * entries_[0].T_odom_sensor).norm(), 1e-9);
  const Pose last = placement_.submaps.back().T_map_submap * knots_[8].T_odom_submap.Inverse();
  EXPECT_LT(Log(trajectory.back().pose.Inverse() * last * entries_.back().T_odom_sensor).norm(),
            1e-9);
}

TEST_F(CorrectedTrajectory, IsOdometryInTheMapWithoutSubmaps) {
  placement_.T_map_odom = Pose::FromXyzRpy(1, 2, 3, 0, 0, 1);
  placement_.submaps.clear();
  for (const auto& knots : {knots_, std::vector<TrajectoryKnot>()}) {
    const Trajectory trajectory = CorrectTrajectory(entries_, knots, placement_);
    ASSERT_EQ(trajectory.size(), entries_.size());
    for (size_t i = 0; i < entries_.size(); ++i) {
      const Pose expected = placement_.T_map_odom * entries_[i].T_odom_sensor;
      EXPECT_LT(Log(trajectory[i].pose.Inverse() * expected).norm(), 1e-12);
    }
  }
  EXPECT_TRUE(CorrectTrajectory({}, knots_, placement_).empty());
}

}  // namespace
}  // namespace isthmus::placement
