#include "lab/simulation/wild/further.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "lab/simulation/manoeuvre.h"
#include "lab/simulation/wild/wild.h"

namespace isthmus::simulation {
namespace {

using wild::Carrier;
using wild::GoOn;
using wild::LongerMotion;

constexpr double kFromS = 5;

// A floor of 60 x 60 m, with a wall across x = 20 m on the left side of the x axis.
Mesh Yard() {
  Mesh mesh;
  mesh.AddQuad({-30, -30, 0}, {30, -30, 0}, {30, 30, 0}, {-30, 30, 0}, Material::kFloor);
  mesh.AddBox({20, 15, 0}, {0.2, 28, 2}, 0, Material::kPlaster);
  return mesh;
}

// Along the x axis at 1.5 m/s, at the origin when it is to go on.
Motion Driving() {
  return [](double t) { return Pose(Eigen::Vector3d(1.5 * (t - kFromS), 0, 0)); };
}

LongerMotion Go(const Motion& base, const std::vector<Eigen::Vector3d>& way) {
  const RayCaster world(Yard());
  Random random(3);
  return GoOn(base, kFromS, way, Carrier(), world, random);
}

double Away(const Pose& pose, const Eigen::Vector3d& from) {
  return (pose.translation() - from).head<2>().norm();
}

// Speed, and rate of turning, at their highest.
struct Rates {
  double mps = 0, radps = 0, mps2 = 0;
};

Rates Highest(const LongerMotion& motion) {
  constexpr double kStep = 0.01;
  Rates highest;
  double before = -1;
  for (double t = kFromS - 1; t < motion.end_s + 1; t += kStep) {
    const Pose by = motion.base(t).Inverse() * motion.base(t + kStep);
    const double mps = by.translation().norm() / kStep;
    highest.mps = std::max(highest.mps, mps);
    highest.radps = std::max(highest.radps, RotationAngle(by) / kStep);
    if (before >= 0) highest.mps2 = std::max(highest.mps2, std::abs(mps - before) / kStep);
    before = mps;
  }
  return highest;
}

TEST(GoOn, IsAsBeforeUntilThenAndComesToRest) {
  const LongerMotion motion = Go(Driving(), {{8, 0, 0}});
  for (const double t : {0.0, 2.5, kFromS}) {
    EXPECT_EQ(motion.base(t).Matrix(), Driving()(t).Matrix());
  }
  const double braking_s = wild::BrakingSeconds(Driving(), kFromS);
  const Pose rest = motion.base(kFromS + braking_s);
  EXPECT_NEAR(rest.translation().x(), 1.5 * braking_s / 2, 1e-9);
  EXPECT_EQ(rest.Matrix(), motion.base(kFromS + braking_s + 0.4).Matrix());
  EXPECT_LT(Away(motion.base(motion.end_s), {8, 0, 0}), 0.1);
  EXPECT_NEAR(motion.metres, 8, 0.1);
  EXPECT_FALSE(motion.blocked);
}

TEST(GoOn, PassesThePointsNoFasterThanItMay) {
  const std::vector<Eigen::Vector3d> way = {{-1, 0, 0}, {-6, 0, 0}, {-6, -9, 0}, {3, -9, 0},
                                            {3, -4, 0}, {3, -9, 0}, {10, -12, 0}};
  const LongerMotion motion = Go(Driving(), way);
  double last_s = kFromS;
  for (const Eigen::Vector3d& point : way) {
    double least = 1e9, when = last_s;
    for (double t = last_s; t < motion.end_s; t += 0.02) {
      const double away = Away(motion.base(t), point);
      if (away >= least) {
        if (least < 0.3) break;
        continue;
      }
      least = away;
      when = t;
    }
    EXPECT_LT(least, 0.25) << point.transpose();
    EXPECT_GE(when, last_s);
    last_s = when;
  }
  const Rates highest = Highest(motion);
  EXPECT_LT(highest.mps, 1.6);
  EXPECT_GT(highest.radps, 0.3);
  EXPECT_LT(highest.radps, 0.8);
  EXPECT_LT(highest.mps2, 3.5);
  const double length = 0.75 + 7 + 9 + 9 + 5 + 5 + std::hypot(7, 3);
  EXPECT_NEAR(motion.metres, length, 0.1 * length);
}

TEST(GoOn, GoesThereAndBack) {
  const LongerMotion motion = Go(StandStill(Pose()), {{2, 0, 0}, {0.1, 0, 0}});
  EXPECT_NEAR(motion.metres, 3.9, 0.4);
  EXPECT_LT(Away(motion.base(motion.end_s), {0.1, 0, 0}), 0.1);
  EXPECT_LT(Highest(motion).radps, 0.8);
}

TEST(GoOn, StopsBeforeAWall) {
  const LongerMotion motion = Go(Driving(), {{4, 3, 0}, {28, 3, 0}});
  EXPECT_TRUE(motion.blocked);
  EXPECT_LT(Away(motion.base(motion.end_s), {19.4, 3, 0}), 0.12);
  EXPECT_FALSE(Go(Driving(), {{4, -3, 0}, {28, -3, 0}}).blocked);
  // There is no ground beyond the yard.
  const LongerMotion beyond = Go(Driving(), {{0, -45, 0}});
  EXPECT_TRUE(beyond.blocked);
  EXPECT_NEAR(beyond.base(beyond.end_s).translation().y(), -29.5, 0.2);
}

TEST(GoOn, StaysWhereThereIsNowhereToGo) {
  const Pose place(Eigen::Vector3d(2, 1, 0));
  const LongerMotion motion = Go(StandStill(place), {{2.2, 1, 0}});
  EXPECT_EQ(motion.base(motion.end_s).Matrix(), place.Matrix());
  EXPECT_EQ(motion.metres, 0);
}

TEST(ToAndFro, TurnsBeforeTheEndsOfAPath) {
  const auto path = wild::Path::Along({{0, 0, 0}, {20, 0, 0}}, 0.4);
  const auto way = wild::ToAndFro(path, 10, 40);
  EXPECT_EQ(way.size(), 80u);
  const auto less = [](const auto& a, const auto& b) { return a.x() < b.x(); };
  EXPECT_NEAR(std::min_element(way.begin(), way.end(), less)->x(), 3.5, 0.6);
  EXPECT_NEAR(std::max_element(way.begin(), way.end(), less)->x(), 16.5, 0.6);
}

// The scans of the one are the first ones of the other, in a world with people, too.
void ExpectBeginning(const Simulator& a, const Simulator& b) {
  ASSERT_GT(b.scan_count(), a.scan_count());
  for (const int scan : {0, a.scan_count() / 2, a.scan_count() - 1}) {
    EXPECT_EQ(a.Truth(0, scan).pose.Matrix(), b.Truth(0, scan).pose.Matrix()) << scan;
    EXPECT_EQ(a.Stamp(0, scan), b.Stamp(0, scan));
    const Scan one = a.MakeScan(0, scan), other = b.MakeScan(0, scan);
    ASSERT_EQ(one.points.size(), other.points.size());
    for (size_t i = 0; i < one.points.size(); ++i) {
      ASSERT_EQ(one.points[i].x, other.points[i].x);
      ASSERT_EQ(one.points[i].intensity, other.points[i].intensity);
    }
  }
}

class EveryKindFurther : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryKindFurther, BeginsAsItDidBefore) {
  WildTeam team{.kind = GetParam(), .sensor = "vlp16", .robots = 2, .seconds = 3};
  const auto drawn = [&] {
    auto drive = DrawWildTeamDrive(8, team, 1);
    EXPECT_TRUE(drive.ok()) << drive.status();
    return *std::move(drive);
  };
  const WildDrive before = drawn();
  team.further = {{.after_scans = before.simulator->scan_count(), .along_m = 6}};
  const WildDrive longer = drawn();
  EXPECT_GT(longer.further_m, 3);
  EXPECT_FALSE(longer.blocked);
  ExpectBeginning(*before.simulator, *longer.simulator);
  // No jump where it goes on.
  const Pose by =
      longer.simulator->PoseAt(0, 2.9999).Inverse() * longer.simulator->PoseAt(0, 3.0001);
  EXPECT_LT(by.translation().norm(), 0.01);
  EXPECT_LT(RotationAngle(by), 2e-3);
  // Again from there, from its end and from its midst.
  const int scans = longer.simulator->scan_count();
  for (const int after : {scans, scans - 30}) {
    team.further.resize(1);
    team.further.push_back({.after_scans = after, .way = {{0, 0, 0}}});
    const WildDrive more = drawn();
    for (const int scan : {29, 60, after - 1}) {
      EXPECT_EQ(longer.simulator->Truth(0, scan).pose.Matrix(),
                more.simulator->Truth(0, scan).pose.Matrix());
    }
  }
}

TEST_P(EveryKindFurther, GoesBackAsItCame) {
  for (const uint64_t seed : {2, 4}) {
    WildTeam team{.kind = GetParam(), .sensor = "vlp16", .robots = 2, .seconds = 20};
    const auto before = DrawWildTeamDrive(seed, team, 1);
    ASSERT_TRUE(before.ok()) << before.status();
    team.further = {{.after_scans = before->simulator->scan_count()}};
    std::vector<Eigen::Vector3d>& way = team.further[0].way;
    for (int s = 40; s >= 0; --s)
      way.push_back(before->simulator->PoseAt(0, s / 2.0).translation());
    const auto longer = DrawWildTeamDrive(seed, team, 1);
    ASSERT_TRUE(longer.ok()) << longer.status();
    EXPECT_FALSE(longer->blocked) << seed << " " << longer->about;
    // The sensor may be a metre ahead of the base, which is on the points.
    const Simulator& simulator = *longer->simulator;
    EXPECT_LT(Away(simulator.Truth(0, simulator.scan_count() - 1).pose, way.back()), 1.5) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(All, EveryKindFurther, ::testing::ValuesIn(WildKinds()),
                         [](const auto& kind) { return kind.param; });

}  // namespace
}  // namespace isthmus::simulation
