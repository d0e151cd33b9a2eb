#include "server/matching/index/place_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "server/matching/index/plan_comparison.h"
#include "server/matching/index/session_plan.h"
#include "server/matching/prepared/prepared_map.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

std::shared_ptr<const SessionPlan> PlanOf(const SessionMap& map) {
  PreparedSubmaps submaps;
  for (const auto& submap : map.submaps) submaps.push_back(PrepareSubmap(submap));
  return std::make_shared<const SessionPlan>(MakeSessionPlan(submaps));
}

// A hall with columns that has nothing in common with the gallery but its height.
Scene MakeColumns() {
  Scene scene;
  scene.boxes = {{{15, 10, -0.25}, {30, 30, 0.25}}, {{15, 10, 4.25}, {30, 30, 0.25}}};
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 4; ++j) {
      scene.boxes.push_back({{2.5 + 6.1 * i, 1.2 + 5.7 * j, 2}, {0.3, 0.3, 2}, 0.7});
    }
  }
  scene.boxes.push_back({{-3, 10, 2}, {0.2, 16, 2}, 0.1});
  return scene;
}

// Two robots whose ways cross in the gallery, and one elsewhere.
class PlanTest : public ::testing::Test {
 protected:
  static Pose T_world_a() { return Pose::FromXyzRpy(3, 3, 1, 0, 0, 0.3); }
  static Pose T_world_b() { return Pose::FromXyzRpy(27, 8, 1, 0, 0, -2.0); }
  static std::vector<Eigen::Vector3d> WayOfB() {
    return Way({{27, 8, 1}, {18, 8, 1}, {13, 6, 1}, {9, 4, 1}}, 20);
  }

  static void SetUpTestSuite() {
    const Scene gallery = MakeGallery();
    a_ = PlanOf(Survey(
        gallery, {Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}}, 20), T_world_a(), 0.01, 1}));
    b_ = PlanOf(Survey(gallery, {WayOfB(), T_world_b(), 0.01, 2}));
    // Mounted at a slant of 20 degrees.
    slanted_ = PlanOf(Survey(
        gallery, {WayOfB(), T_world_b() * Pose::FromXyzRpy(0, 0, 0, 0.25, -0.25, 0), 0.01, 3}));
    elsewhere_ = PlanOf(Survey(MakeColumns(), {WayOfB(), T_world_b(), 0.01, 4}));
  }

  static inline std::shared_ptr<const SessionPlan> a_, b_, slanted_, elsewhere_;
};

TEST_F(PlanTest, ShowsWallsAndWhereTheRobotLookedAcross) {
  const auto in_plan = [](double x, double y) {
    const Eigen::Vector3d at = T_world_a().Inverse() * Eigen::Vector3d(x, y, 1);
    return Eigen::Vector2f(at.head<2>().cast<float>());
  };
  EXPECT_TRUE(a_->IsFree(in_plan(3, 3)));     // The robot's first position.
  EXPECT_TRUE(a_->IsFree(in_plan(12.1, 6)));  // A door.
  EXPECT_FALSE(a_->IsFree(in_plan(12.1, 2)));
  EXPECT_FALSE(a_->IsFree(in_plan(-3, 3)));  // Outside.
  EXPECT_FALSE(a_->IsFree({1e6f, -1e6f}));
  // The wall beside the door, which it passed on one side and then on the other.
  const Eigen::Vector2f beside = in_plan(12.0, 2);
  bool is_wall = false;
  for (const SessionPlan::Wall& wall : a_->walls) {
    is_wall = is_wall || ((wall.position - beside).norm() < 0.4f && wall.blocks);
  }
  EXPECT_TRUE(is_wall);
}

TEST_F(PlanTest, PlacesOneOnTheOther) {
  const PlanarPose placement = PlanComparer(b_).PlaceOn(*a_);
  const Pose T_a_b = T_world_a().Inverse() * T_world_b();
  const Eigen::Matrix3d R = T_a_b.RotationMatrix();
  EXPECT_LT(std::abs(std::remainder(placement.yaw - std::atan2(R(1, 0), R(0, 0)), 2 * M_PI)), 0.05);
  const Eigen::Vector2d middle = b_->center.cast<double>();
  const Eigen::Vector3d at = T_a_b * Eigen::Vector3d(middle.x(), middle.y(), 0);
  EXPECT_LT((placement.Apply(middle) - at.head<2>()).norm(), 0.5);
}

TEST_F(PlanTest, WhatWasSeenByBothFitsBetter) {
  PlanComparer of_a(a_);
  const double same = of_a.Score(*b_), other = of_a.Score(*elsewhere_);
  EXPECT_GT(same, 1.5 * other);
  EXPECT_GT(of_a.Score(*slanted_), 1.5 * other);
  EXPECT_NEAR(PlanComparer(b_).Score(*a_), same, 0.2 * same);
  EXPECT_EQ(of_a.Score(*b_), same);  // Earlier comparisons do not matter.
}

TEST_F(PlanTest, NothingFitsNothing) {
  EXPECT_EQ(PlanOf(SessionMap())->walls.size(), 0u);
  EXPECT_EQ(PlanComparer(a_).Score(*PlanOf(SessionMap())), 0);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(PlanComparer(a_).Score(*b_, stop.get_token()), 0);
}

TEST_F(PlanTest, LargerCellsShowTheSame) {
  const SessionPlan coarse = Coarsen(*a_, 4 * a_->cell_m);
  EXPECT_LT(coarse.walls.size(), a_->walls.size() / 3);
  EXPECT_GT(coarse.walls.size(), a_->walls.size() / 16);
  for (const SessionPlan::Wall& wall : coarse.walls) {
    EXPECT_LE(wall.normal.norm(), wall.weight + 1e-4f);
    EXPECT_FALSE(coarse.IsFree(wall.position));
  }
  EXPECT_EQ(Coarsen(*a_, a_->cell_m).walls.size(), a_->walls.size());
}

SessionId Name(int i) { return SessionId("s" + std::to_string(10 + i)); }

std::vector<std::pair<SessionId, SessionId>> Sessions(const std::vector<RankedPair>& ranked) {
  std::vector<std::pair<SessionId, SessionId>> sessions;
  sessions.reserve(ranked.size());
  for (const RankedPair& pair : ranked) sessions.push_back(pair.sessions);
  return sessions;
}

// 20 sessions whose scores are much alike.
PlaceIndex MakeIndex() {
  PlaceIndex index;
  for (int a = 0; a < 20; ++a) {
    for (int b = a + 1; b < 20; ++b) index.Put(Name(a), Name(b), 1 + 0.01 * ((7 * a + 3 * b) % 10));
  }
  return index;
}

TEST(PlaceIndexTest, WhatStandsOutComesFirst) {
  PlaceIndex index = MakeIndex();
  index.Put(Name(17), Name(3), 1.5);
  // Fits everywhere, and so nowhere in particular.
  for (int b = 0; b < 20; ++b) index.Put(Name(9), Name(b), 3);
  const auto ranked = index.Rank(20);
  EXPECT_EQ(ranked.front().sessions, std::pair(Name(3), Name(17)));
  EXPECT_EQ(ranked.size(), 190u);
  EXPECT_TRUE(std::is_sorted(ranked.begin(), ranked.end(),
                             [](const auto& a, const auto& b) { return a.promise > b.promise; }));
}

TEST(PlaceIndexTest, EverySessionHasItsPartners) {
  const auto ranked = MakeIndex().Rank(3);
  EXPECT_LE(ranked.size(), 60u);
  std::map<SessionId, int> partners;
  for (const RankedPair& pair : ranked) {
    EXPECT_LT(pair.sessions.first, pair.sessions.second);
    ++partners[pair.sessions.first];
    ++partners[pair.sessions.second];
  }
  ASSERT_EQ(partners.size(), 20u);
  for (const auto& [session, count] : partners) EXPECT_GE(count, 3) << session.value();
  EXPECT_EQ(Sessions(ranked), Sessions(MakeIndex().Rank(3)));
}

TEST(PlaceIndexTest, ASearchCountsForBoth) {
  const auto pair = [](int a, int b) { return RankedPair{{Name(a), Name(b)}, 0}; };
  const std::vector<RankedPair> ranked = {pair(0, 1), pair(2, 3), pair(0, 2), pair(1, 4)};
  // 4 has room still, though 1 has none.
  EXPECT_EQ(Sessions(TakePartners(ranked, 1)), Sessions({pair(0, 1), pair(2, 3), pair(1, 4)}));
  EXPECT_EQ(TakePartners(ranked, 2).size(), 4u);
  EXPECT_TRUE(TakePartners(ranked, 0).empty());
}

TEST(PlaceIndexTest, ForgetsSessions) {
  PlaceIndex index = MakeIndex();
  EXPECT_TRUE(index.Has(Name(4), Name(2)));
  index.Forget(Name(4));
  EXPECT_FALSE(index.Has(Name(4), Name(2)));
  EXPECT_FALSE(index.Has(Name(2), Name(4)));
  index.ForgetIf([](const SessionId& id) { return id > Name(5); });
  EXPECT_EQ(index.Rank(100).size(), 10u);  // All pairs of 5.
  index.ForgetIf([](const SessionId&) { return true; });
  EXPECT_TRUE(index.Rank(6).empty());
}

TEST(PlaceIndexTest, AFewSessionsAreRankedToo) {
  PlaceIndex index;
  EXPECT_TRUE(index.Rank(6).empty());
  index.Put(Name(1), Name(1), 5);  // With itself.
  EXPECT_TRUE(index.Rank(6).empty());
  index.Put(Name(1), Name(0), 5);
  EXPECT_EQ(Sessions(index.Rank(6)), Sessions({{{Name(0), Name(1)}, 0}}));
}

}  // namespace
}  // namespace isthmus::matching
