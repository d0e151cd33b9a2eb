#include "server/matching/loops/meetings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/geometry/angles.h"
#include "server/matching/pairs/matcher.h"
#include "server/matching/pairs/odom_transform.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

// A corridor of 8 m around a block of 44 by 28 m, with cabinets that nothing repeats.
Scene MakeRing() {
  Scene scene;
  scene.boxes = {Between(-1, -1, -0.5, 61, 45, 0),   Between(-1, -1, 4, 61, 45, 4.5),
                 Between(-0.5, -0.5, 0, 0, 44.5, 4), Between(60, -0.5, 0, 60.5, 44.5, 4),
                 Between(0, -0.5, 0, 60, 0, 4),      Between(0, 44, 0, 60, 44.5, 4),
                 Between(8, 8, 0, 52, 36, 4)};
  std::mt19937 rng(7);
  const auto random = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng);
  };
  const auto put = [&](double x, double y) {
    const Eigen::Vector3d half(random(0.3, 1.2), random(0.3, 0.8), random(0.5, 1.9));
    scene.boxes.push_back({{x, y, half.z()}, half, random(0, M_PI)});
  };
  for (double s = 2; s < 58; s += random(3, 6)) {
    put(s, random(0.5, 2));
    put(s, random(42, 43.5));
  }
  for (double s = 10; s < 40; s += random(3, 6)) {
    put(random(0.5, 2), s);
    put(random(58, 59.5), s);
  }
  return scene;
}

// The robots begin in the west, a goes round in the south and b in the north, and both come to the
// corner in the north-east: some 100 m each. They are known to meet where they began.
class MeetingsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const Scene ring = MakeRing();
    true_a_ = Survey(ring, {Way({{4, 20, 1}, {4, 4, 1}, {56, 4, 1}, {56, 40, 1}, {40, 40, 1}}, 60),
                            T_world_a(), 0.01, 1});
    true_b_ = Survey(
        ring, {Way({{4, 6, 1}, {4, 40, 1}, {56, 40, 1}, {56, 26, 1}}, 50), T_world_b(), 0.01, 2});
    b_ = true_b_;
    b_.submaps = Stray(true_b_.submaps, Pose::FromXyzRpy(0.03, 0.03, 0, 0, 0, 0.5 * kRadPerDeg));
  }

  static Pose T_world_a() { return Pose::FromXyzRpy(4, 20, 1, 0, 0, -1.5); }
  static Pose T_world_b() { return Pose::FromXyzRpy(4, 6, 1, 0, 0, 1.5); }
  static Pose T_a_b() { return T_world_a().Inverse() * T_world_b(); }

  static Pose TrueEdge(uint32_t a, uint32_t b) {
    return true_a_.submaps[a]->T_odom_submap.Inverse() * T_a_b() *
           true_b_.submaps[b]->T_odom_submap;
  }
  static double Error(const SubmapEdge& edge) {
    return (TrueEdge(edge.submap_a, edge.submap_b).Inverse() * edge.T_a_b).translation().norm();
  }

  // The hypothesis by which the first submaps lie on each other, and the others as odometry has
  // them.
  static Hypothesis Joined(const SessionMap& a, const SessionMap& b) {
    Hypothesis h;
    h.converged = true;
    h.T_a_b = T_a_b();
    h.joint.T_a_b = h.T_a_b;
    h.joint.poses = MapPoses::Rigid(a, b, h.T_a_b);
    for (uint32_t k = 0; k < 2; ++k) {
      h.joint.edges.push_back({k, k, TrueEdge(k, k), 1e4 * Matrix6d::Identity()});
    }
    return h;
  }

  static SessionMap First(SessionMap map, size_t count) {
    map.submaps.resize(count);
    return map;
  }

  static inline SessionMap true_a_, true_b_, b_;
};

TEST_F(MeetingsTest, AreFoundWhereDriftHasTheMapsMetresApart) {
  const PreparedMap a(true_a_), b(b_);
  const Hypothesis h = Joined(true_a_, b_);
  const size_t last_a = true_a_.submaps.size() - 1, last_b = b_.submaps.size() - 1;
  const Pose T_placed = h.joint.poses.a[last_a].Inverse() * h.joint.poses.b[last_b];
  EXPECT_GT(Error({static_cast<uint32_t>(last_a), static_cast<uint32_t>(last_b), T_placed}), 2.5);
  const Meetings found = FindMeetings(a, b, h, LoopOptions());
  ASSERT_FALSE(found.ties.empty());
  for (const SubmapEdge& tie : found.ties) EXPECT_LT(Error(tie), 0.05);
  EXPECT_TRUE(std::ranges::any_of(found.ties, [](const auto& tie) { return tie.submap_b > 5; }));
}

TEST_F(MeetingsTest, AreNotLookedForTwice) {
  const PreparedMap a(true_a_), b(b_);
  Hypothesis h = Joined(true_a_, b_);
  h.meetings = FindMeetings(a, b, h, LoopOptions()).memory;
  EXPECT_EQ(h.meetings.asked_a, true_a_.submaps.size());
  EXPECT_EQ(h.meetings.asked_b, b_.submaps.size());
  EXPECT_TRUE(FindMeetings(a, b, h, LoopOptions()).ties.empty());
}

// Whichever robot comes to the corner last.
TEST_F(MeetingsTest, AreFoundByTheSubmapsOfEitherThatCame) {
  for (const bool a_comes_last : {false, true}) {
    const size_t of_a = true_a_.submaps.size(), of_b = b_.submaps.size();
    const SessionMap first_a = First(true_a_, a_comes_last ? of_a / 2 : of_a);
    const SessionMap first_b = First(b_, a_comes_last ? of_b : of_b / 2);
    const PreparedMap a_before(first_a), b_before(first_b);
    Meetings found = FindMeetings(a_before, b_before, Joined(first_a, first_b), LoopOptions());
    EXPECT_TRUE(found.ties.empty());
    Hypothesis h = Joined(true_a_, b_);
    h.meetings = found.memory;
    found =
        FindMeetings(PreparedMap(true_a_, a_before), PreparedMap(b_, b_before), h, LoopOptions());
    ASSERT_FALSE(found.ties.empty()) << a_comes_last;
    for (const SubmapEdge& tie : found.ties) EXPECT_LT(Error(tie), 0.05) << a_comes_last;
  }
}

TEST_F(MeetingsTest, AreNoneWhereLoopsAreNotWanted) {
  LoopOptions options;
  options.min_path_length_m = 1000;
  EXPECT_TRUE(FindMeetings(PreparedMap(true_a_), PreparedMap(b_), Joined(true_a_, b_), options)
                  .ties.empty());
}

// As odometry has b, its last submaps are where a drove; in truth they are in the north-west.
TEST_F(MeetingsTest, AreNoneWhereTheWaysOnlySeemToMeet) {
  SessionMap b = b_;
  const size_t half = b.submaps.size() / 2;
  const SessionMap elsewhere = Survey(MakeRing(), {Way({{4, 24, 1}, {4, 40, 1}, {34, 40, 1}}, 25),
                                                   Pose::FromXyzRpy(4, 24, 1, 0, 0, 0), 0.01, 3});
  for (size_t k = half; k < b.submaps.size(); ++k) {
    auto moved = std::make_shared<Submap>(*elsewhere.submaps[k - half]);
    moved->id = b.submaps[k]->id;
    moved->T_odom_submap = b.submaps[k]->T_odom_submap;
    b.submaps[k] = std::move(moved);
  }
  EXPECT_TRUE(FindMeetings(PreparedMap(true_a_), PreparedMap(b), Joined(true_a_, b), LoopOptions())
                  .ties.empty());
}

TEST_F(MeetingsTest, BendAnAcceptedMatchAndHold) {
  const PreparedMap a(true_a_), b(b_);
  PairMemory memory;
  memory.a = true_a_;
  memory.b = b_;
  memory.hypotheses = {Joined(true_a_, b_)};
  memory.accepted = true;
  memory.searched = true_a_.submaps.size() + b_.submaps.size();
  PairMatcher matcher(InTheGallery(), memory);
  Match match = matcher.Update(a, b);
  const Hypothesis* joined = matcher.joined();
  ASSERT_NE(joined, nullptr);
  ASSERT_TRUE(matcher.Tie(a, b, FindMeetings(a, b, *joined, LoopOptions()), &match));
  EXPECT_EQ(match.state, MatchState::kAccepted);
  const auto is_far = [](const SubmapEdge& edge) { return edge.submap_b > 5; };
  EXPECT_TRUE(std::ranges::any_of(match.edges, is_far));
  EXPECT_TRUE(std::ranges::any_of(match.edges, std::not_fn(is_far)));
  for (const SubmapEdge& edge : match.edges) EXPECT_LT(Error(edge), 0.1);
  EXPECT_LT(match.free_space, 0.02);
  const Match searched = matcher.Update(a, b, true);
  EXPECT_EQ(searched.state, MatchState::kAccepted) << searched.detail;
  EXPECT_TRUE(std::ranges::any_of(searched.edges, is_far));
  EXPECT_TRUE(std::ranges::any_of(searched.edges, std::not_fn(is_far)));
}

// Both drive the south side to the west, side by side: b goes on round the block to the corner in
// the north-east, where a came from. Known are the south side and, by a tie, that corner.
class TiedStretchTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const Scene ring = MakeRing();
    true_a_ = Survey(ring, {Way({{56, 36, 1}, {56, 4, 1}, {4, 4, 1}}, 40), T_world_a(), 0.01, 1});
    true_b_ = Survey(ring, {Way({{44, 5, 1}, {4, 5, 1}, {4, 40, 1}, {56, 40, 1}, {56, 30, 1}}, 65),
                            T_world_b(), 0.01, 2});
    true_b_.session = SessionId("robot_b-0001");
    const Pose stray = Pose::FromXyzRpy(0.1, 0.05, 0, 0, 0, 3 * kRadPerDeg);
    a_ = true_a_;
    a_.submaps = Stray(true_a_.submaps, stray);
    b_ = true_b_;
    b_.submaps = Stray(true_b_.submaps, stray);
  }

  static Pose T_world_a() { return Pose::FromXyzRpy(56, 36, 1, 0, 0, -1.5); }
  static Pose T_world_b() { return Pose::FromXyzRpy(44, 5, 1, 0, 0, 3.1); }

  static SubmapEdge True(uint32_t a, uint32_t b) {
    const Pose T_a_b = (T_world_a() * true_a_.submaps[a]->T_odom_submap).Inverse() * T_world_b() *
                       true_b_.submaps[b]->T_odom_submap;
    return {a, b, T_a_b, 1e4 * Matrix6d::Identity()};
  }

  static double Error(const SubmapEdge& edge) {
    const Pose T_true = True(edge.submap_a, edge.submap_b).T_a_b;
    return (T_true.Inverse() * edge.T_a_b).translation().norm();
  }

  // Joined along the stretch, and tied at the other end.
  static JointRefinement Tied() {
    JointRefinement joint;
    const auto last_a = static_cast<uint32_t>(a_.submaps.size() - 1);
    for (uint32_t k = 0; k < kStretch; ++k) joint.edges.push_back(True(last_a - 3 + k, k));
    joint.ties = {True(0, static_cast<uint32_t>(b_.submaps.size() - 1))};
    joint.T_a_b = *FitRigid(FramePoses::AsMatched(a_, b_), joint.edges, Pose());
    joint.poses = MapPoses::Rigid(a_, b_, joint.T_a_b);
    return joint;
  }

  static constexpr uint32_t kStretch = 4;
  static inline SessionMap true_a_, true_b_, a_, b_;
};

TEST_F(TiedStretchTest, IsNotTornByTheTie) {
  JointRefinement joint = Tied();
  const auto [tied_a, tied_b, T_tied, information] = joint.ties.front();
  const Pose T_placed = joint.poses.a[tied_a].Inverse() * joint.poses.b[tied_b];
  EXPECT_GT((T_placed.Inverse() * T_tied).translation().norm(), 10);
  // Submaps of a torn stretch are farther apart than that.
  ASSERT_TRUE(RefineJointly(PreparedMap(a_), PreparedMap(b_), 1.0, 0, 0, &joint));
  for (const SubmapEdge& edge : joint.edges) EXPECT_LT(Error(edge), 0.1);
  for (uint32_t k = 0; k < kStretch; ++k) {
    EXPECT_TRUE(std::ranges::any_of(joint.edges, [&](const auto& e) { return e.submap_b == k; }));
  }
}

}  // namespace
}  // namespace isthmus::matching
