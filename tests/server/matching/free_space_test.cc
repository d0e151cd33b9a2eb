#include "server/matching/prepared/free_space.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/server/matching/scene.h"
#include "tests/server/matching/whole_maps.h"

namespace isthmus::matching {
namespace {

class FreeSpaceTest : public ::testing::Test {
 protected:
  static Pose T_world_a() { return Pose::FromXyzRpy(3, 3, 1, 0.02, -0.03, 0.3); }
  static Pose T_world_b() { return Pose::FromXyzRpy(27, 8, 1, -0.04, 0.01, -2.0); }
  static Pose T_a_b() { return T_world_a().Inverse() * T_world_b(); }

  static void SetUpTestSuite() {
    const Scene scene = MakeGallery();
    map_a_ = Survey(
        scene, {Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}}, 15), T_world_a(), 0.01, 1});
    map_b_ = Survey(
        scene, {Way({{27, 8, 1}, {18, 8, 1}, {13, 6, 1}, {9, 4, 1}}, 15), T_world_b(), 0.01, 2});
  }

  static FreeSpaceScore Score(const Pose& T_a_b) {
    return ScoreFreeSpace(map_a_, map_b_, T_a_b, FreeSpaceOptions());
  }

  static inline SessionMap map_a_, map_b_;
};

TEST_F(FreeSpaceTest, TheTruthIsNotContradicted) {
  const FreeSpaceScore score = Score(T_a_b());
  EXPECT_GT(score.comparisons(), 3000);
  EXPECT_LT(score.violation(), 0.005);
}

TEST_F(FreeSpaceTest, WrongPlacementsAreContradicted) {
  for (const Pose& off : {Pose(Eigen::Vector3d(3, 0, 0)), Pose(Eigen::Vector3d(-4, 2, 0)),
                          Pose::FromXyzRpy(30, 20, 0, 0, 0, M_PI)}) {
    const FreeSpaceScore score = Score(T_world_a().Inverse() * off * T_world_b());
    EXPECT_GT(score.comparisons(), 1000);
    EXPECT_GT(score.violation(), 0.05);
  }
}

TEST_F(FreeSpaceTest, BothOrdersSayTheSame) {
  const FreeSpaceScore forward = Score(T_a_b());
  const FreeSpaceScore backward =
      ScoreFreeSpace(map_b_, map_a_, T_a_b().Inverse(), FreeSpaceOptions());
  EXPECT_EQ(forward.agree, backward.agree);
  EXPECT_EQ(forward.front, backward.front);
}

TEST_F(FreeSpaceTest, MapsOutOfReachSayNothing) {
  const FreeSpaceScore score = Score(Pose(Eigen::Vector3d(500, 0, 0)));
  EXPECT_EQ(score.comparisons(), 0);
  EXPECT_EQ(score.violation(), 0);
}

// A car that drives along with the robot leaves walls all along the way; they are no evidence.
TEST_F(FreeSpaceTest, WhatMovedIsNotAsked) {
  Scene scene = MakeGallery();
  SessionMap moving;
  moving.session = SessionId("moving");
  for (int k = 0; k < 12; ++k) {
    const Eigen::Vector3d at(2.0 + 0.7 * k, 3, 1);
    Scene now = scene;
    now.boxes.push_back({at + Eigen::Vector3d(2.5, 0.5, 0), {0.3, 0.3, 1}, 0.2});
    SessionMap one = Survey(now, {{at}, Pose(), 0.01, static_cast<unsigned>(k)});
    moving.submaps.push_back(one.submaps.front());
  }
  const FreeSpaceScore score = ScoreFreeSpace(moving, moving, Pose(), FreeSpaceOptions());
  EXPECT_GT(score.comparisons(), 1000);
  EXPECT_LT(score.violation(), 0.01);
}

// A survey compared with another one, in which something stands besides.
class SomethingStands {
 public:
  explicit SomethingStands(const SceneBox& box) {
    const std::vector<Eigen::Vector3d> way = Way({{13, 6, 1}, {20, 7, 1}, {22, 5, 1}}, 10);
    Scene scene = MakeGallery();
    const SessionMap without = Survey(scene, {way, Pose(), 0.01, 1});
    scene.boxes.push_back(box);
    SessionMap with = Survey(scene, {way, Pose(), 0.01, 2});
    with.session = SessionId("with");
    score_ = ScoreFreeSpace(without, with, Pose(), FreeSpaceOptions());
  }
  const FreeSpaceScore& score() const { return score_; }

 private:
  FreeSpaceScore score_;
};

// The robot that sees a person stand never looks through him; others do.
TEST_F(FreeSpaceTest, APersonWhoStandsIsNotAsked) {
  const SomethingStands person({{15, 9.5, 0.9}, {0.4, 0.35, 0.9}, 0.4});
  EXPECT_GT(person.score().comparisons(), 3000);
  EXPECT_LT(person.score().violation(), 0.001);
  EXPECT_EQ(person.score().contradicted_regions, 0);
}

TEST_F(FreeSpaceTest, AWallIsAsked) {
  const SomethingStands wall({{15, 9.5, 1}, {1.2, 0.1, 1}, 0.4});
  EXPECT_GT(wall.score().front, 50);
  EXPECT_GT(wall.score().contradicted_regions, 1);
}

// It reaches higher than a person.
TEST_F(FreeSpaceTest, AColumnIsAsked) {
  const SomethingStands column({{15, 9.5, 2}, {0.25, 0.3, 2}, 0.4});
  EXPECT_GT(column.score().front, 50);
  EXPECT_GT(column.score().contradicted_regions, 1);
}

}  // namespace
}  // namespace isthmus::matching
