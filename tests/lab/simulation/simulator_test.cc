#include "lab/simulation/simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/simulation/worlds/cars.h"
#include "lab/simulation/worlds/walkers.h"

namespace isthmus::simulation {
namespace {

using ::testing::HasSubstr;

constexpr Noise kExact{0, 0, 0};
const Eigen::Vector3d kRoom(12, 8, 4);  // Centred over the origin, on the floor.

World RoomWorld() {
  World world;
  world.mesh.AddBox(Eigen::Vector3d::Zero(), kRoom, 0, Material::kPlaster);
  return world;
}

Simulator InRoom(const Motion& motion, const Noise& noise, const std::string& sensor = "vlp16") {
  Options options;
  options.noise = noise;
  return Simulator(RoomWorld(), {motion}, *MakeLidar(sensor), options);
}

// Signed distance to the nearest of the room's six faces; negative outside.
double Depth(const Eigen::Vector3d& p) {
  const Eigen::Vector3d half = kRoom / 2;
  const Eigen::Vector3d inside = half - (p - Eigen::Vector3d(0, 0, half.z())).cwiseAbs();
  return inside.minCoeff();
}

TEST(Simulator, StandingInABoxMeasuresExactRanges) {
  const Pose T_world_sensor = Pose::FromXyzRpy(1, -0.5, 0.8, 0.05, -0.03, 0.7);
  for (const std::string& sensor : LidarNames()) {
    const Simulator simulator = InRoom([&](double) { return T_world_sensor; }, kExact, sensor);
    const Scan scan = simulator.MakeScan(0, 0);
    ASSERT_EQ(scan.points.size(), simulator.lidar().firings.size());  // Closed room: no misses.
    for (size_t i = 0; i < scan.points.size(); ++i) {
      const ScanPoint& p = scan.points[i];
      const Firing& firing = simulator.lidar().firings[i];
      const Eigen::Vector3d direction = T_world_sensor.rotation() * firing.direction.cast<double>();
      double expected = 1e9;  // To the first face in that direction.
      for (int axis = 0; axis < 3; ++axis) {
        const double low = axis == 2 ? 0 : -kRoom[axis] / 2, high = low + kRoom[axis];
        const double face = direction[axis] > 0 ? high : low;
        const double range = (face - T_world_sensor.translation()[axis]) / direction[axis];
        if (std::isfinite(range)) expected = std::min(expected, range);
      }
      ASSERT_NEAR(Eigen::Vector3f(p.x, p.y, p.z).norm(), expected, 2e-4) << sensor << " " << i;
      ASSERT_EQ(p.ring, firing.ring);
    }
  }
}

// Drives and turns at the same time, as fast as any robot here does.
Pose Swerve(double t) { return Pose::FromXyzRpy(-3 + 2 * t, 0.5 * t, 0.8, 0, 0.02 * t, 0.8 * t); }

TEST(Simulator, EveryFiringComesFromItsOwnPose) {
  const Simulator simulator = InRoom(Swerve, kExact);
  double worst = 0, worst_at_end_pose = 0;
  for (const int index : {0, 5}) {
    const Scan scan = simulator.MakeScan(0, index);
    const double end = 0.1 * (index + 1);
    for (const ScanPoint& p : scan.points) {
      const Eigen::Vector3d at(p.x, p.y, p.z);
      worst = std::max(worst, std::abs(Depth(Swerve(end + double{p.time}) * at)));
      worst_at_end_pose = std::max(worst_at_end_pose, std::abs(Depth(Swerve(end) * at)));
    }
  }
  EXPECT_LT(worst, 1e-3);
  EXPECT_GT(worst_at_end_pose, 0.2);  // The motion within the scan is there.
}

TEST(Simulator, RangeNoiseIsAsLargeAsSaid) {
  const Simulator simulator = InRoom(Swerve, {0.02, 0, 0});
  const Scan noisy = simulator.MakeScan(0, 3), exact = InRoom(Swerve, kExact).MakeScan(0, 3);
  ASSERT_EQ(noisy.points.size(), exact.points.size());
  double sum = 0, squares = 0;
  for (size_t i = 0; i < noisy.points.size(); ++i) {
    const ScanPoint &a = noisy.points[i], &b = exact.points[i];
    const double error = std::hypot(a.x, a.y, a.z) - std::hypot(b.x, b.y, b.z);
    sum += error;
    squares += error * error;
  }
  const auto count = static_cast<double>(noisy.points.size());
  EXPECT_NEAR(sum / count, 0, 0.001);
  EXPECT_NEAR(std::sqrt(squares / count), 0.02, 0.001);
}

TEST(Simulator, DropoutLosesThatShare) {
  const Simulator simulator = InRoom(Swerve, {0, 0.25, 0});
  const double kept = static_cast<double>(simulator.MakeScan(0, 0).points.size()) /
                      static_cast<double>(simulator.lidar().firings.size());
  EXPECT_NEAR(kept, 0.75, 0.02);
}

TEST(Simulator, WeakReturnsFadeWithRange) {
  World plain;
  plain.mesh.AddBox({0, 0, -1}, {400, 400, 1}, 0, Material::kAsphalt);
  Options options;
  const Motion standing = [](double) { return Pose(Eigen::Vector3d(0, 0, 1.8)); };
  const Simulator simulator(plain, {standing}, *MakeLidar("vlp16"), options);
  int near = 0, far = 0;
  for (const ScanPoint& p : simulator.MakeScan(0, 0).points) {
    ++(std::hypot(p.x, p.y) < 25 ? near : far);
  }
  // Four rings look down on ground nearer than 25 m or so, three farther away.
  EXPECT_GT(near, 5 * 1700);
  EXPECT_LT(far, 1800);
}

TEST(Simulator, StampsSequencesAndTimes) {
  Options options;
  options.seconds = 2;
  const auto simulator = *Simulator::Create(options);
  EXPECT_EQ(simulator->scan_count(), 20);
  ASSERT_EQ(simulator->Truth(1).size(), 20u);
  for (const int index : {0, 7}) {
    const Scan scan = simulator->MakeScan(1, index);
    EXPECT_EQ(scan.sequence, static_cast<uint64_t>(index) + 1);
    EXPECT_EQ(scan.end_stamp_ns, options.start_stamp_ns + (index + 1) * int64_t{100'000'000});
    EXPECT_EQ(scan.end_stamp_ns, simulator->Truth(1)[index].stamp_ns);
    EXPECT_TRUE(scan.has_ring && scan.has_time);
    ASSERT_GT(scan.points.size(), 20'000u);
    float before = -0.1f;
    for (const ScanPoint& p : scan.points) {
      ASSERT_GE(p.time, before);
      ASSERT_LE(p.time, 0);
      before = p.time;
    }
  }
}

TEST(Simulator, IsDeterministicBySeedInAnyOrder) {
  const auto points = [](uint64_t seed, const std::vector<int>& order) {
    Options options;
    options.seed = seed;
    options.seconds = 1;
    const auto simulator = *Simulator::Create(options);
    Scan last;
    for (const int index : order) last = simulator->MakeScan(0, index);
    std::vector<float> flat;
    for (const ScanPoint& p : last.points) flat.insert(flat.end(), {p.x, p.y, p.z, p.intensity});
    return flat;
  };
  EXPECT_EQ(points(1, {4}), points(1, {2, 9, 4}));
  EXPECT_NE(points(1, {4}), points(2, {4}));
}

TEST(Simulator, WalkersStandBeforeWhatIsBehindThem) {
  Options options;
  options.noise = kExact;
  options.seconds = 5;
  const auto empty = *Simulator::Create(options);
  options.walkers = 20;
  const auto busy = *Simulator::Create(options);
  int nearer = 0;
  for (const int index : {10, 40}) {
    const Scan a = empty->MakeScan(0, index), b = busy->MakeScan(0, index);
    ASSERT_EQ(a.points.size(), b.points.size());  // Closed building: a return either way.
    for (size_t i = 0; i < a.points.size(); ++i) {
      const float before = std::hypot(a.points[i].x, a.points[i].y, a.points[i].z);
      const float now = std::hypot(b.points[i].x, b.points[i].y, b.points[i].z);
      ASSERT_LE(now, before);
      nearer += now < before ? 1 : 0;
    }
  }
  EXPECT_GT(nearer, 50);
  EXPECT_LT(nearer, 12000);
}

TEST(Walkers, AreCylindersWhereTheyWalk) {
  const Motion walk = [](double t) { return Pose(Eigen::Vector3d(4 + t, 0, 0.5)); };
  const Walkers walkers({walk}, 0, 2);
  const auto range = [&](double fraction, const Eigen::Vector3f& origin, float slope) {
    Hit hit;
    const Eigen::Vector3f direction = Eigen::Vector3f(1, 0, slope).normalized();
    walkers.Occlude({origin, direction}, fraction, 50, hit);
    return hit.range_m;
  };
  EXPECT_NEAR(range(0, {0, 0, 1}, 0), 3.75, 1e-5);
  EXPECT_NEAR(range(0.5, {0, 0, 1}, 0), 4.75, 1e-5);
  EXPECT_LT(range(0, {0, 0.26f, 1}, 0), 0);     // Past it,
  EXPECT_LT(range(0, {0, 0, 2.3f}, 0), 0);      // above it,
  EXPECT_LT(range(0, {0, 0, 0.4f}, 0), 0);      // below its feet,
  EXPECT_LT(range(0, {5, 0, 1}, 0), 0);         // away from it,
  EXPECT_LT(range(0, {4.1f, 0, 1}, 0), 0);      // from inside.
  EXPECT_GT(range(0, {0, 0, 1}, 0.2f), 3.75f);  // Upwards it is farther.
}

TEST(Cars, AreBodiesWithCabinsWhereTheyDrive) {
  // Crosses ahead from right to left: 1.8 m wide as seen along x, 4.4 m long along y.
  const Motion drive = [](double t) {
    return Pose::FromXyzRpy(10, 8 * t, 0.5, 0, 0, std::numbers::pi / 2);
  };
  const Cars cars({drive}, 0, 0.1);
  const auto look = [&](double fraction, const Eigen::Vector3f& origin, float slope) {
    Hit hit;
    cars.Occlude({origin, Eigen::Vector3f(1, 0, slope).normalized()}, fraction, 50, hit);
    return hit;
  };
  EXPECT_NEAR(look(0, {0, 0, 1}, 0).range_m, 9.1, 1e-5);           // The body,
  EXPECT_NEAR(look(0, {0, 0, 1.6f}, 0).range_m, 10 - 0.78, 1e-5);  // the cabin on it,
  EXPECT_LT(look(0, {0, 1.5f, 1.6f}, 0).range_m, 0);               // before the cabin,
  EXPECT_LT(look(0, {0, 0, 2}, 0).range_m, 0);                     // above it,
  EXPECT_LT(look(0, {0, 0, 0.7f}, 0).range_m, 0);                  // below the body.
  EXPECT_LT(look(0, {0, 2.5f, 1}, 0).range_m, 0);                  // It comes
  EXPECT_NEAR(look(1, {0, 2.5f, 1}, 0).range_m, 9.1, 1e-5);        // along within the turn.
  EXPECT_LT(look(0, {20, 0, 1}, 0).range_m, 0);                    // Away from it,
  EXPECT_LT(look(0, {10, 0, 1}, 0).range_m, 0);                    // from inside.
  EXPECT_NEAR(look(0, {0, 0, 1}, 0).cosine, 1, 1e-6);
  // From above onto the roof of the body's front: half a metre down on five along.
  EXPECT_NEAR(look(0, {5, 1.5f, 1.85f}, -0.1f).range_m, 5 * std::hypot(1, 0.1), 1e-4);
  EXPECT_NEAR(look(0, {5, 1.5f, 1.85f}, -0.1f).cosine, 0.1 / std::hypot(1, 0.1), 1e-5);
}

TEST(Simulator, CarsDriveOnTheRightAlongStreets) {
  const World world = *MakeWorld("campus", 3);
  const auto traffic = MakeTraffic(world, 6, 20, 3);
  ASSERT_EQ(traffic.size(), 6u);
  for (const Motion& car : traffic) {
    double path_length = 0;
    for (double t = 0; t < 20; t += 0.1) {
      const Eigen::Vector3d at = car(t).translation();
      const double step = (car(t + 0.1).translation() - at).norm();
      EXPECT_GT(step, 0);    // Slow in the sharpest bends, but never standing.
      EXPECT_LT(step, 1.0);  // The outer side of a bend is faster than the middle.
      EXPECT_LT(world.roads.Distance(at.head<2>()), 3.2);
      EXPECT_NEAR(at.z(), world.ground.Height(at.x(), at.y()), 1e-9);
      path_length += step;
    }
    EXPECT_GT(path_length, 20 * 1.5);
  }
}

TEST(Simulator, CarsAreSeenOnStreetsOnly) {
  Options options;
  options.world = "campus";
  options.noise = kExact;
  options.seconds = 5;
  const auto empty = *Simulator::Create(options);
  options.cars = 40;
  const auto busy = *Simulator::Create(options);
  int changed = 0;
  for (const int index : {5, 25, 45}) {
    const Scan a = empty->MakeScan(0, index), b = busy->MakeScan(0, index);
    const size_t shared = std::min(a.points.size(), b.points.size());
    for (size_t i = 0; i < shared; ++i) changed += a.points[i].x != b.points[i].x ? 1 : 0;
  }
  EXPECT_GT(changed, 100);
}

// Cars that stand are there at first and gone at the end; marked points are of them alone.
TEST(Simulator, ParkedCarsLeaveAndAreMarked) {
  Options options;
  options.world = "campus";
  options.robots = 1;
  options.seconds = 20;
  options.parked = 100;
  options.truth = Truth::kMoving;
  const auto marked = *Simulator::Create(options);
  const auto count = [&](int index) {
    const Scan scan = marked->MakeScan(0, index);
    return std::count_if(scan.points.begin(), scan.points.end(),
                         [](const ScanPoint& point) { return point.intensity == 255; });
  };
  EXPECT_GT(count(0) + count(20) + count(40), 50);
  EXPECT_EQ(count(160) + count(180) + count(199), 0);
  options.parked = 0;
  options.truth = Truth::kNone;
  const auto plain = *Simulator::Create(options);
  EXPECT_EQ(plain->MakeScan(0, 199).points.size(), marked->MakeScan(0, 199).points.size());
}

TEST(Simulator, RefusesOptionsThatMakeNoSense) {
  const auto error = [](const auto& change) {
    Options options;
    change(options);
    const auto status = Simulator::Create(options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(error([](Options& o) { o.world = "moon"; }), HasSubstr("museum"));
  EXPECT_THAT(error([](Options& o) { o.sensor = "radar"; }), HasSubstr("vlp16"));
  EXPECT_THAT(error([](Options& o) { o.robots = 0; }), HasSubstr("robots"));
  EXPECT_THAT(error([](Options& o) { o.walkers = -1; }), HasSubstr("walkers"));
  EXPECT_THAT(error([](Options& o) { o.cars = 101; }), HasSubstr("cars"));
  EXPECT_THAT(error([](Options& o) { o.cars = 1; }), HasSubstr("streets"));  // In a museum.
  EXPECT_THAT(error([](Options& o) { o.parked = 101; }), HasSubstr("parked"));
  EXPECT_THAT(error([](Options& o) { o.parked = 1; }), HasSubstr("streets"));
  EXPECT_THAT(error([](Options& o) { o.seconds = NAN; }), HasSubstr("seconds"));
  EXPECT_THAT(error([](Options& o) { o.noise.dropout = 2; }), HasSubstr("dropout"));
  EXPECT_THAT(error([](Options& o) { o.noise.range_sigma_m = -1; }), HasSubstr("noise"));
}

}  // namespace
}  // namespace isthmus::simulation
