#include "server/matching/asking/asked_drives.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "server/matching/asking/driven_ways.h"
#include "server/matching/asking/forecast.h"
#include "server/matching/asking/seen_ground.h"
#include "server/matching/pairs/probability.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

// Robot a stays in the west of the gallery's large hall; b comes by and goes on through the others.
class AskedDrivesTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    scene_ = MakeGallery();
    a_ = new PreparedMap(Survey(scene_, {Way({{2, 2, 1}, {9, 3, 1}, {9, 6, 1}}, 15), T_world_a()}));
    b_ = new PreparedMap(
        Survey(scene_, {Way({{6, 8, 1}, {13, 6, 1}, {23, 10.5, 1}, {23.5, 14, 1}, {28, 14, 1}}, 35),
                        T_world_b(), 0.01, 2}));
  }
  static void TearDownTestSuite() {
    delete a_;
    delete b_;
  }

  static Pose T_world_a() { return Pose::FromXyzRpy(2, 2, 1, 0.04, -0.03, 0.3); }
  static Pose T_world_b() { return Pose::FromXyzRpy(6, 8, 1, -0.05, 0.02, -2); }
  static Pose T_a_b() { return T_world_a().Inverse() * T_world_b(); }

  static MapPoses Poses() { return MapPoses::Rigid(a_->session_map(), b_->session_map(), T_a_b()); }

  // The right hypothesis as it is found where little is shared, lacking ground.
  static Hypothesis Right() {
    Hypothesis h;
    h.converged = true;
    h.T_a_b = T_a_b();
    h.joint.poses = Poses();
    h.residual_m = 0.07;
    h.upright_ratio = 0.5;
    h.distinctive = 20;
    h.things = {.there = 8, .gone = 0};
    h.own = {.near = 1000,
             .on = 900,
             .squared_m2 = 900 * 0.03 * 0.03,
             .near_upright = 500,
             .on_upright = 430};
    h.free_space = {.agree = 900, .front = 9, .regions = 100, .contradicted_regions = 0};
    h.shared_area_m2 = 60;
    h.shared_share = 0.3;
    h.observability = 0.2;
    return h;
  }

  // The points of a way in the world.
  static std::vector<Eigen::Vector3d> InWorld(const AskedDrive& drive) {
    const SessionMap& map = (drive.by_b ? b_ : a_)->session_map();
    const Pose T_world_odom = drive.by_b ? T_world_b() : T_world_a();
    std::vector<Eigen::Vector3d> points;
    for (const WayPoint& point : drive.way) {
      const auto submap =
          std::find_if(map.submaps.begin(), map.submaps.end(),
                       [&](const auto& one) { return one->id.index == point.submap; });
      points.push_back(T_world_odom * (*submap)->T_odom_submap * point.position);
    }
    return points;
  }

  static bool IsFree(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const double length = (to - from).norm();
    if (length < 1e-6) return true;
    const double wall = scene_.Cast(from, (to - from) / length);
    return wall < 0 || wall > length;
  }

  static inline Scene scene_;
  static inline PreparedMap *a_ = nullptr, *b_ = nullptr;
};

TEST_F(AskedDrivesTest, LeadAlongDrivenWaysPastNoWall) {
  const std::vector<AskedDrive> drives = AskForDrives(*a_, *b_, {Right()}, {});
  ASSERT_FALSE(drives.empty());
  for (const AskedDrive& drive : drives) {
    const std::vector<Eigen::Vector3d> way = InWorld(drive);
    ASSERT_GE(way.size(), 2u);
    double length = 0;
    for (size_t i = 1; i < way.size(); ++i) {
      EXPECT_TRUE(IsFree(way[i - 1], way[i])) << "step " << i;
      length += (way[i] - way[i - 1]).norm();
    }
    EXPECT_NEAR(drive.length_m, length, 1e-6);
    EXPECT_LT(drive.leaves_own, way.size() - 1);
    const SessionMap& map = (drive.by_b ? b_ : a_)->session_map();
    const Pose& newest = map.submaps.back()->keyframes.back().T_submap_sensor;
    EXPECT_EQ(drive.way.front().submap, map.submaps.back()->id.index);
    EXPECT_LT((drive.way.front().position - newest.translation()).norm(), 1.5);
  }
}

TEST_F(AskedDrivesTest, PromiseWhatTheMatchNeeds) {
  const Hypothesis now = Right();
  const std::vector<AskedDrive> drives = AskForDrives(*a_, *b_, {now}, {});
  ASSERT_FALSE(drives.empty());
  EXPECT_GT(drives.front().confidence, ProbabilityAlone(now));
  EXPECT_FALSE(drives.front().by_b) << "Robot b has seen the corner of robot a, not a the rest.";
  EXPECT_EQ(drives.front().rival, 0u);
}

TEST_F(AskedDrivesTest, GoNoFartherThanIsNeeded) {
  MatcherOptions easy, hard;
  easy.min_probability = ProbabilityAlone(Right()) + 1e-3;
  hard.min_probability = 0.999;
  const auto shorter = AskForDrives(*a_, *b_, {Right()}, easy);
  const auto longer = AskForDrives(*a_, *b_, {Right()}, hard);
  ASSERT_FALSE(shorter.empty());
  ASSERT_FALSE(longer.empty());
  EXPECT_LT(shorter.front().length_m, longer.front().length_m);
}

TEST_F(AskedDrivesTest, AskNothingWhereNothingIsPlaced) {
  Hypothesis loose = Right();
  loose.joint.poses = {};
  EXPECT_TRUE(AskForDrives(*a_, *b_, {loose}, {}).empty());
  EXPECT_TRUE(AskForDrives(*a_, *b_, {}, {}).empty());
}

// Robot b is behind a wall without a door.
TEST_F(AskedDrivesTest, LeadThroughNoWall) {
  Scene halls;
  halls.boxes = {Between(-1, -1, -0.5, 41, 11, 0),    Between(-0.5, -0.5, 0, 0, 10.5, 4),
                 Between(40, -0.5, 0, 40.5, 10.5, 4), Between(0, -0.5, 0, 40, 0, 4),
                 Between(0, 10, 0, 40, 10.5, 4),      Between(20, 0, 0, 20.3, 10, 4)};
  const Pose T_world_a(Eigen::Vector3d(10, 5, 1)), T_world_b(Eigen::Vector3d(24, 5, 1));
  const PreparedMap a(Survey(halls, {Way({{10, 5, 1}, {18, 5, 1}}, 10), T_world_a}));
  const PreparedMap b(Survey(halls, {Way({{24, 5, 1}, {36, 5, 1}}, 10), T_world_b}));
  const Pose T_a_b = T_world_a.Inverse() * T_world_b;
  const DrivenWays ways(a, b, MapPoses::Rigid(a.session_map(), b.session_map(), T_a_b));
  const EasiestWays from_a = ways.From(*ways.Newest(false));
  const SharedGround ground = MeasureSharedGround(ways.stops(), from_a, false, b, false);
  for (size_t i = 0; i < ways.stops().size(); ++i) {
    EXPECT_EQ(std::isfinite(from_a.length_m[i]), !ways.stops()[i].of_b);
    EXPECT_EQ(ground.ahead[i].ground_m2, 0);
  }
}

TEST_F(AskedDrivesTest, NewGroundGrowsAlongTheWay) {
  const DrivenWays ways(*a_, *b_, Poses());
  const EasiestWays from_a = ways.From(*ways.Newest(false));
  const SharedGround ground = MeasureSharedGround(ways.stops(), from_a, false, *b_, false);
  double most = 0;
  for (size_t i = 0; i < ground.ahead.size(); ++i) {
    const Evidence before = from_a.before[i] ? ground.ahead[*from_a.before[i]] : Evidence();
    EXPECT_GE(ground.ahead[i].ground_m2, before.ground_m2);
    EXPECT_GE(ground.ahead[i].distinctive, before.distinctive - 1e-6);
    EXPECT_GE(ground.ahead[i].things, before.things - 1e-6);
    most = std::max(most, ground.ahead[i].ground_m2);
  }
  // The gallery has some 600 m2, of which a sees half from where it is.
  EXPECT_GT(most, 100);
  EXPECT_LT(most, 500);
}

TEST(ForecastTest, MoreGroundOfTheSameKindMakesItSurerAndIsCountedOnce) {
  Hypothesis h;
  h.shared_area_m2 = 100;
  h.distinctive = 50;
  h.things = {.there = 4, .gone = 1};
  h.residual_m = 0.06;
  h.own = {.near = 100, .on = 100, .squared_m2 = 100 * 0.03 * 0.03};
  h.free_space = {.agree = 900, .front = 100, .regions = 90, .contradicted_regions = 9};
  const Hypothesis same = Foresee(h, {}, 100);
  const Hypothesis more = Foresee(h, {.ground_m2 = 200, .distinctive = 200, .things = 8}, 100);
  EXPECT_EQ(MeasureLogOdds(same).sum(), MeasureLogOdds(h).sum());
  EXPECT_EQ(more.shared_area_m2, 200);
  EXPECT_EQ(more.distinctive, 150);
  EXPECT_EQ(more.things.there, 8);
  EXPECT_NEAR(more.residual_m, std::sqrt((0.06 * 0.06 + 0.03 * 0.03) / 2), 1e-9);
  EXPECT_GT(more.free_space.comparisons(), 1990);
  EXPECT_LT(more.free_space.front, 110) << "What is contradicted now is not contradicted twice.";
  EXPECT_GT(ProbabilityAlone(more), ProbabilityAlone(h));
}

}  // namespace
}  // namespace isthmus::matching
