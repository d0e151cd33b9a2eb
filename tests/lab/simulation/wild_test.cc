#include "lab/simulation/wild/wild.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "lab/simulation/sensors/ray_caster.h"
#include "lab/simulation/wild/path.h"

namespace isthmus::simulation {
namespace {

using ::testing::HasSubstr;

std::vector<float> Flat(const Scan& scan) {
  std::vector<float> flat{static_cast<float>(scan.end_stamp_ns % 1'000'000'000)};
  for (const ScanPoint& p : scan.points) flat.insert(flat.end(), {p.x, p.y, p.z, p.intensity});
  return flat;
}

WildDrive Draw(uint64_t seed, const std::string& kind, double seconds,
               const std::string& sensor = "vlp16") {
  return *DrawWildDrive(seed, {kind, sensor, seconds});
}

// The range of the nearest hit from `at`, by rays in a level circle, up and `ahead`; leaves and
// panes are left out.
float Nearest(const RayCaster& caster, const Eigen::Vector3d& at, const Eigen::Vector3d& ahead) {
  constexpr int kRays = 32;
  std::vector<Ray> rays;
  for (int i = 0; i < kRays; ++i) {
    const double angle = 2 * std::numbers::pi * i / kRays;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    rays.push_back({at.cast<float>(), out.cast<float>()});
  }
  rays.push_back({at.cast<float>(), Eigen::Vector3f::UnitZ()});
  if (ahead.norm() > 0) rays.push_back({at.cast<float>(), ahead.normalized().cast<float>()});
  std::vector<Hit> hits(rays.size());
  caster.Cast(rays, 5, hits);
  float nearest = 5;
  for (const Hit& hit : hits) {
    if (hit.range_m >= 0 && hit.material != Material::kLeaves) {
      nearest = std::min(nearest, hit.range_m);
    }
  }
  return nearest;
}

class EveryKind : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryKind, FollowsFromItsSeed) {
  const WildDrive a = Draw(7, GetParam(), 2), b = Draw(7, GetParam(), 2);
  EXPECT_EQ(a.kind, GetParam());
  EXPECT_EQ(a.about, b.about);
  EXPECT_EQ(Flat(a.simulator->MakeScan(0, 5)), Flat(b.simulator->MakeScan(0, 5)));
  EXPECT_NE(Flat(a.simulator->MakeScan(0, 5)),
            Flat(Draw(8, GetParam(), 2).simulator->MakeScan(0, 5)));
}

TEST_P(EveryKind, DrivesThroughNothing) {
  for (const uint64_t seed : {1, 2, 3, 4}) {
    constexpr double kSeconds = 20, kStep = 0.2;
    const WildDrive drive = Draw(seed, GetParam(), kSeconds);
    const RayCaster caster(drive.simulator->world().mesh);
    double path_length = 0;
    for (double t = 0; t + kStep < kSeconds; t += kStep) {
      const Eigen::Vector3d at = drive.simulator->PoseAt(0, t).translation();
      const Eigen::Vector3d by = drive.simulator->PoseAt(0, t + kStep).translation() - at;
      path_length += by.norm();
      ASSERT_GT(Nearest(caster, at, by), std::min(0.15, by.norm()))
          << drive.about << " seed " << seed << " at " << t << " s, " << at.transpose();
    }
    EXPECT_GT(path_length, 1) << drive.about;
    EXPECT_LT(path_length, 15 * kSeconds) << drive.about;
  }
}

TEST_P(EveryKind, StandsOnSomething) {
  const WildDrive drive = Draw(5, GetParam(), 10);
  const RayCaster caster(drive.simulator->world().mesh);
  for (double t = 0; t < 10; t += 0.5) {
    const Ray down{drive.simulator->PoseAt(0, t).translation().cast<float>(),
                   -Eigen::Vector3f::UnitZ()};
    Hit hit;
    caster.Cast({&down, 1}, 10, {&hit, 1});
    EXPECT_GT(hit.range_m, 0.1) << t << " " << drive.about;
    EXPECT_LT(hit.range_m, 2.9) << t << " " << drive.about;
  }
}

TEST_P(EveryKind, SeesEnoughToDriveBy) {
  for (const uint64_t seed : {11, 12}) {
    const WildDrive drive = Draw(seed, GetParam(), 2);
    EXPECT_GT(drive.simulator->MakeScan(0, 3).points.size(), 3000u) << drive.about;
  }
}

INSTANTIATE_TEST_SUITE_P(Wild, EveryKind, ::testing::ValuesIn(WildKinds()),
                         [](const auto& kind) { return kind.param; });

TEST(Wild, MovesAsSmoothlyAsBodiesDo) {
  for (uint64_t seed = 20; seed < 40; ++seed) {
    const WildDrive drive = *DrawWildDrive(seed, {"field", "vlp16", 20});
    const auto at = [&](double t) { return drive.simulator->PoseAt(0, t); };
    constexpr double kStep = 0.02;
    for (double t = kStep; t < 20; t += kStep) {
      const Pose before = at(t - kStep), now = at(t), after = at(t + kStep);
      const Eigen::Vector3d bend =
          after.translation() - 2 * now.translation() + before.translation();
      ASSERT_LT(bend.norm() / (kStep * kStep), 40) << seed << " " << drive.about << " at " << t;
      ASSERT_LT(RotationAngle(before.Inverse() * after) / (2 * kStep), 4) << seed << " at " << t;
    }
  }
}

TEST(Wild, NamingWhatWouldBeDrawnChangesNothing) {
  const WildDrive drawn = *DrawWildDrive(3, {"", "", 1});
  const std::string sensor = drawn.simulator->lidar().name;
  const WildDrive named = *DrawWildDrive(3, {drawn.kind, sensor, 1});
  EXPECT_EQ(Flat(drawn.simulator->MakeScan(0, 2)), Flat(named.simulator->MakeScan(0, 2)));
}

TEST(Wild, DrawsEveryKindAndSensor) {
  std::set<std::string> kinds, sensors;
  for (uint64_t seed = 0; seed < 200; ++seed) {
    const WildOptions chosen = *ChooseWild(seed, {});
    kinds.insert(chosen.kind);
    sensors.insert(chosen.sensor);
  }
  EXPECT_EQ(kinds.size(), WildKinds().size());
  EXPECT_EQ(sensors.size(), 18u);
}

TEST(Wild, IsAWorldToSimulate) {
  Options options{.world = "wild-mine", .robots = 1, .seconds = 1, .seed = 9};
  const auto simulator = Simulator::Create(options);
  ASSERT_TRUE(simulator.ok()) << simulator.status();
  EXPECT_EQ(Flat((*simulator)->MakeScan(0, 3)), Flat(Draw(9, "mine", 1).simulator->MakeScan(0, 3)));
  options.robots = 2;
  EXPECT_THAT(Simulator::Create(options).status().message(), HasSubstr("--robots 1"));
  options.robots = 1;
  options.world = "wild-moon";
  EXPECT_THAT(Simulator::Create(options).status().message(), HasSubstr("forest"));
}

TEST(Wild, SaysWhatThereIs) {
  const auto error = [](const WildOptions& options) {
    const auto status = DrawWildDrive(1, options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(error({"moon", "vlp16", 1}), HasSubstr("forest"));
  EXPECT_THAT(error({"road", "radar", 1}), HasSubstr("vlp16"));
  EXPECT_THAT(error({"road", "vlp16", 0}), HasSubstr("0 s"));
}

TEST(Path, IsAsLongAsItSaysAndRunsThroughItsCorners) {
  const wild::Path path = wild::Path::Along({{0, 0, 0}, {20, 0, 0}, {20, 10, 3}}, 0.5);
  double length = 0, nearest_to_corner = 1e9;
  for (double s = 0; s + 0.05 <= path.length(); s += 0.05) {
    const Eigen::Vector3d a = path.At(s).position, b = path.At(s + 0.05).position;
    length += (b - a).head<2>().norm();
    nearest_to_corner = std::min(nearest_to_corner, (a - Eigen::Vector3d(20, 0, 0)).norm());
  }
  EXPECT_NEAR(length, path.length(), 0.1);
  EXPECT_NEAR(length, 30, 1.5);
  EXPECT_LT(nearest_to_corner, 0.3);
  EXPECT_NEAR(path.At(25).pitch, -std::atan(0.3), 0.01);  // Uphill is nose up.
  EXPECT_NEAR(path.At(25).yaw, std::numbers::pi / 2, 0.01);
}

TEST(Path, TurnsWhereItGoesBackAsItCame) {
  for (const double round_m : {0.4, 0.9, 2.2}) {
    const wild::Path path = wild::Path::Along(
        {{0, 0, 0}, {9, 0, 0}, {0, 0, 0}, {0, 0, 0}, {9, 0.3, 0}, {9, 9, 0}}, round_m);
    for (double s = 0; s + 0.01 <= path.length(); s += 0.01) {
      const double turned = path.At(s + 0.01).yaw - path.At(s).yaw;
      ASSERT_LT(std::abs(std::remainder(turned, 2 * std::numbers::pi)), 0.5) << round_m << " " << s;
      ASSERT_LT(path.At(s).position.y(), 9.1);
      ASSERT_GT(path.At(s).position.y(), -0.3);
    }
  }
}

TEST(Path, LiesOnASlopeAsWheelsDo) {
  Random random(1);
  wild::Path path = wild::Path::Wandering({40, 1e6, 0, 10}, random);  // Along x.
  path.Lay([](const Eigen::Vector2d& at) { return 0.1 * at.x() + 0.2 * at.y(); }, 0.6);
  const wild::Path::Sample at = path.At(20);
  EXPECT_NEAR(at.position.z(), 0.1 * at.position.x(), 1e-6);
  EXPECT_NEAR(at.pitch, -std::atan(0.1), 1e-6);
  EXPECT_NEAR(at.roll, std::atan(0.2), 1e-6);  // The left side is higher.
}

TEST(PathIndex, FindsTheNearest) {
  Random random(3);
  const wild::Path path = wild::Path::Wandering({80, 30, 1, 5}, random);
  const wild::PathIndex index(path);
  for (int i = 0; i < 200; ++i) {
    const double x = random.Uniform(-10, 70);
    const Eigen::Vector2d at(x, random.Uniform(-20, 20));
    double nearest = 12;
    for (double s = 0; s <= path.length(); s += 0.1) {
      nearest = std::min(nearest, (path.At(s).position.head<2>() - at).norm());
    }
    EXPECT_NEAR(index.Distance(at, 12), nearest, 0.3);
  }
}

// Teams.

WildDrive DrawMember(uint64_t seed, const std::string& kind, int robot,
                     WildTwin twin = WildTwin::kNone) {
  return *DrawWildTeamDrive(seed, {kind, "vlp16", 3, 10, twin}, robot);
}

TEST_P(EveryKind, TeamsDriveThroughNothing) {
  for (const uint64_t seed : {1, 2}) {
    for (int robot = 0; robot < 3; ++robot) {
      const WildDrive drive = DrawMember(seed, GetParam(), robot);
      const RayCaster caster(drive.simulator->world().mesh);
      for (double t = 0; t + 0.2 < 10; t += 0.2) {
        const Eigen::Vector3d at = drive.simulator->PoseAt(0, t).translation();
        const Eigen::Vector3d by = drive.simulator->PoseAt(0, t + 0.2).translation() - at;
        ASSERT_GT(Nearest(caster, at, by), std::min(0.12, by.norm()))
            << drive.about << " seed " << seed << " robot " << robot << " at " << t << " s";
      }
    }
  }
}

TEST_P(EveryKind, TeamsFollowFromTheirSeed) {
  const WildDrive a = DrawMember(7, GetParam(), 1), b = DrawMember(7, GetParam(), 1);
  EXPECT_EQ(Flat(a.simulator->MakeScan(0, 5)), Flat(b.simulator->MakeScan(0, 5)));
  const WildDrive other = DrawMember(7, GetParam(), 2);
  EXPECT_NE(Flat(a.simulator->MakeScan(0, 5)), Flat(other.simulator->MakeScan(0, 5)));
}

// A room of a hotel, seen from where another robot of the team was: the walls are where they were.
TEST(WildTeam, RobotsShareAWorldAndTwinsItsPlan) {
  const WildDrive a = DrawMember(4, "hotel", 0),
                  twin = DrawMember(4, "hotel", 0, WildTwin::kRefurnished);
  EXPECT_EQ(a.simulator->PoseAt(0, 3).Matrix(), twin.simulator->PoseAt(0, 3).Matrix());
  std::vector<Ray> rays;
  const Eigen::Vector3f at = a.simulator->PoseAt(0, 3).translation().cast<float>();
  for (int i = 0; i < 360; ++i) {
    const float angle = static_cast<float>(i) * std::numbers::pi_v<float> / 180;
    rays.push_back({at, {std::cos(angle), std::sin(angle), -0.3f}});
  }
  std::vector<Hit> hits(rays.size()), of_twin(rays.size()), of_other(rays.size());
  RayCaster(a.simulator->world().mesh).Cast(rays, 50, hits);
  RayCaster(twin.simulator->world().mesh).Cast(rays, 50, of_twin);
  RayCaster(DrawMember(4, "hotel", 2).simulator->world().mesh).Cast(rays, 50, of_other);
  const auto same = [&](const std::vector<Hit>& others) {
    int count = 0;
    for (size_t i = 0; i < hits.size(); ++i) {
      count += std::abs(hits[i].range_m - others[i].range_m) < 0.01;
    }
    return count;
  };
  EXPECT_GT(same(of_twin), 180);
  EXPECT_LT(same(of_twin), 360) << "nothing loose is the same";
  EXPECT_GT(same(of_other), 180);
}

TEST(WildTeam, SaysWhoIsNotOfIt) {
  EXPECT_EQ(DrawWildTeamDrive(1, {"house", "vlp16", 2, 10}, 2).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(DrawWildTeamDrive(1, {"nowhere", "vlp16", 2, 10}, 0).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(DrawWildTeamDrive(1, {"house", "eye", 2, 10}, 0).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace isthmus::simulation
