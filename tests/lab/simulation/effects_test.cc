#include "lab/simulation/sensors/effects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "lab/simulation/simulator.h"

namespace isthmus::simulation {
namespace {

constexpr Noise kNoNoise{0, 0, 0};

// Standing in the middle of a square room of 20 m with something in it.
Simulator WithEffects(const Effects& effects, const std::function<void(Mesh*)>& furnish = {}) {
  World world;
  world.mesh.AddBox(Eigen::Vector3d::Zero(), {20, 20, 8}, 0, Material::kPlaster);
  if (furnish) furnish(&world.mesh);
  Options options;
  options.noise = kNoNoise;
  options.effects = effects;
  const Pose standing(Eigen::Vector3d(0, 0, 2));
  return Simulator(std::move(world), {[standing](double) { return standing; }}, *MakeLidar("vlp16"),
                   options);
}

float Range(const ScanPoint& p) { return std::hypot(p.x, p.y, p.z); }

// Firings that both scans have and of which `differs` holds.
template <typename Differs>
int Count(const Scan& a, const Scan& b, Differs differs) {
  std::map<std::pair<float, int>, ScanPoint> by_firing;
  for (const ScanPoint& p : a.points) by_firing[{p.time, p.ring}] = p;
  int count = 0;
  for (const ScanPoint& p : b.points) {
    const auto same = by_firing.find({p.time, p.ring});
    count += same != by_firing.end() && differs(same->second, p) ? 1 : 0;
  }
  return count;
}

// Straight ahead, between the floor and the ceiling.
bool IsAhead(const ScanPoint& p) { return std::abs(p.y) < 2 && p.z > -1.5f && p.z < 1.5f; }

TEST(Effects, NoneChangeNothing) {
  EXPECT_FALSE(Effects().Disturb());
  const Scan scan = WithEffects({}).MakeScan(0, 4);
  EXPECT_EQ(scan.points.size(), MakeLidar("vlp16")->firings.size());
  EXPECT_EQ(scan.end_stamp_ns, WithEffects({}).Truth(0, 4).stamp_ns);
}

TEST(Effects, RainIsSeenNearBefore) {
  const Scan dry = WithEffects({}).MakeScan(0, 0), wet = WithEffects({.rain = 0.1}).MakeScan(0, 0);
  const auto nearer = [](const auto& a, const auto& b) { return Range(b) < Range(a) - 1e-3f; };
  const double share = Count(dry, wet, nearer) / static_cast<double>(dry.points.size());
  EXPECT_GT(share, 0.05);
  EXPECT_LT(share, 0.1);
}

TEST(Effects, DustHidesASide) {
  const Scan clear = WithEffects({}).MakeScan(0, 0),
             dusty = WithEffects({.dust = 0.5}).MakeScan(0, 0);
  EXPECT_LT(dusty.points.size(), clear.points.size());
  EXPECT_GT(dusty.points.size(), clear.points.size() / 2);
  const auto near = [](const ScanPoint& p) { return Range(p) < 5; };
  EXPECT_GT(std::count_if(dusty.points.begin(), dusty.points.end(), near),
            std::count_if(clear.points.begin(), clear.points.end(), near));
}

void AddPane(Mesh* mesh) {
  mesh->AddQuad({5, -3, 0.5}, {5, 3, 0.5}, {5, 3, 4}, {5, -3, 4}, Material::kGlass);
}

TEST(Effects, GlassPassesOrMirrors) {
  const Scan solid = WithEffects({}, AddPane).MakeScan(0, 0);
  const Scan clear = WithEffects({.glass = 1e-6}, AddPane).MakeScan(0, 0);
  const Scan mirror = WithEffects({.glass = 1}, AddPane).MakeScan(0, 0);
  const auto on_pane = [](const ScanPoint& p) { return std::abs(p.x - 5) < 1e-3; };
  const auto behind = [](const ScanPoint& p) { return std::abs(p.x - 10) < 1e-2; };
  const auto image = [](const ScanPoint& p) { return p.x > 10.1f; };  // Behind the wall.
  const auto count = [](const Scan& scan, const auto& is) {
    return std::count_if(scan.points.begin(), scan.points.end(), is);
  };
  EXPECT_GT(count(solid, on_pane), 1000);
  EXPECT_EQ(count(solid, image), 0);
  EXPECT_LT(count(clear, on_pane), count(solid, on_pane) / 10);
  EXPECT_GT(count(clear, behind), count(solid, behind) + 1000);
  EXPECT_GT(count(mirror, image), 200);
  // The image of the wall behind the sensor, 10 m behind it and 5 m more either way.
  const auto wall = [](const ScanPoint& p) { return std::abs(p.x - 20) < 0.1; };
  EXPECT_GT(count(mirror, wall), 100);
}

TEST(Effects, FoliageIsHitInPart) {
  const auto hedge = [](Mesh* mesh) {
    for (double y = -3; y < 3; y += 0.2) {
      mesh->AddQuad({4, y, 0}, {4, y + 0.1, 0}, {4, y + 0.1, 4}, {4, y, 4}, Material::kLeaves);
      mesh->AddQuad({4.5, y, 0}, {4.5, y + 0.2, 0}, {4.5, y + 0.2, 4}, {4.5, y, 4},
                    Material::kLeaves);
    }
  };
  const Scan whole = WithEffects({}, hedge).MakeScan(0, 0);
  const Scan part = WithEffects({.foliage = 1}, hedge).MakeScan(0, 0);
  const auto within = [](const ScanPoint& p) { return IsAhead(p) && p.x > 4.02f && p.x < 4.48f; };
  EXPECT_EQ(std::count_if(whole.points.begin(), whole.points.end(), within), 0);
  EXPECT_GT(std::count_if(part.points.begin(), part.points.end(), within), 300);
}

TEST(Effects, RetroReflectorsBloom) {
  const auto sign = [](Mesh* mesh) {
    mesh->AddQuad({5, -0.2, 1.8}, {5, 0.2, 1.8}, {5, 0.2, 2.2}, {5, -0.2, 2.2}, Material::kRetro);
  };
  const auto on_sign = [](const Scan& scan) {
    return std::count_if(scan.points.begin(), scan.points.end(),
                         [](const ScanPoint& p) { return IsAhead(p) && p.x > 4.5f && p.x < 5.1f; });
  };
  const auto plain = on_sign(WithEffects({}, sign).MakeScan(0, 0));
  const auto blooming = on_sign(WithEffects({.blooming_rad = 0.05}, sign).MakeScan(0, 0));
  EXPECT_GT(plain, 10);
  EXPECT_GT(blooming, 2 * plain);
}

TEST(Effects, EdgesHavePointsBetween) {
  const auto post = [](Mesh* mesh) { mesh->AddBox({9, 0, 0}, {0.4, 1, 4}, 0, Material::kStone); };
  const auto between = [](const Scan& scan) {
    return std::count_if(scan.points.begin(), scan.points.end(), [](const ScanPoint& p) {
      return p.x > 9.3f && p.x < 9.95f && std::abs(p.y) < 0.7f;
    });
  };
  EXPECT_EQ(between(WithEffects({}, post).MakeScan(0, 0)), 0);
  EXPECT_GT(between(WithEffects({.mixed = 1}, post).MakeScan(0, 0)), 5);
}

TEST(Effects, RingsAreOffByAsMuchAsSaid) {
  const Scan exact = WithEffects({}).MakeScan(0, 0);
  const Scan off = WithEffects({.ring_range_sigma_m = 0.02}).MakeScan(0, 0);
  ASSERT_EQ(off.points.size(), exact.points.size());
  std::vector<double> by_ring(16), first(16, NAN);
  double squares = 0;
  for (size_t i = 0; i < off.points.size(); ++i) {
    const double by = Range(off.points[i]) - Range(exact.points[i]);
    double& of_ring = first[off.points[i].ring];
    if (std::isnan(of_ring)) of_ring = by;
    ASSERT_NEAR(by, of_ring, 1e-5);  // The same for all of a ring.
  }
  for (const double by : first) squares += by * by;
  EXPECT_NEAR(std::sqrt(squares / 16), 0.02, 0.01);
  const Scan askew = WithEffects({.ring_angle_sigma_rad = 0.002}).MakeScan(0, 0);
  const auto differs = [](const auto& a, const auto& b) {
    return std::abs(Range(a) - Range(b)) > 1e-3f;
  };
  EXPECT_GT(Count(exact, askew, differs), 1000);
}

TEST(Effects, PacketsAreLostWhole) {
  const Scan scan = WithEffects({.packet_loss = 0.3}).MakeScan(0, 0);
  const size_t all = MakeLidar("vlp16")->firings.size(), lost = all - scan.points.size();
  EXPECT_NEAR(static_cast<double>(lost) / static_cast<double>(all), 0.3, 0.12);
  EXPECT_EQ(lost % 16, 0u);
}

TEST(Effects, ShadesAreInTheSensorsFrame) {
  Effects effects;
  effects.shades = {{1, 0.2f, 1.5f, 0.6f}, {-1, 0.2f, 1.5f, 0}};
  const Scan scan = WithEffects(effects).MakeScan(0, 0);
  for (const ScanPoint& p : scan.points) {
    const double azimuth = std::atan2(p.y, p.x);
    ASSERT_GT(std::abs(azimuth + 1), 0.199);
    const double off = std::abs(azimuth - 1);
    ASSERT_TRUE(off > 0.199 || std::abs(Range(p) - 0.6) < 1e-4) << off;
    ASSERT_TRUE(off < 0.201 || Range(p) > 2) << off;
  }
}

TEST(Effects, StampsJitterAndDrift) {
  const Simulator simulator = WithEffects({.stamp_jitter_s = 0.01, .clock_drift = 1e-3});
  double least = 1, most = 0;
  for (int i = 0; i < 100; ++i) {
    const double late =
        1e-9 * static_cast<double>(simulator.Stamp(0, i) - simulator.Truth(0, i).stamp_ns);
    const double jitter = late - 1e-3 * 0.1 * (i + 1);
    least = std::min(least, jitter);
    most = std::max(most, jitter);
    EXPECT_EQ(simulator.Stamp(0, i), simulator.Stamp(0, i));
  }
  EXPECT_GE(least, -1e-9);
  EXPECT_LT(least, 0.001);
  EXPECT_GT(most, 0.005);
  EXPECT_LE(most, 0.01);
  EXPECT_EQ(simulator.MakeScan(0, 7).end_stamp_ns, simulator.Stamp(0, 7));
}

}  // namespace
}  // namespace isthmus::simulation
