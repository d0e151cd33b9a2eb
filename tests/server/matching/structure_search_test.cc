#include "server/matching/search/structure_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stop_token>

#include "core/geometry/angles.h"
#include "server/matching/pairs/candidate_search.h"
#include "server/matching/prepared/prepared_map.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

// Posts at random on a level field, without a wall: a wood.
Scene MakeWood() {
  Scene scene;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> at(-20, 60);
  scene.boxes.push_back({{20, 20, -0.5}, {80, 80, 0.5}});
  for (int i = 0; i < 220; ++i) {
    const double x = at(random), y = at(random);
    if (std::abs(y - 20) < 1.5) continue;  // The way.
    scene.boxes.push_back({{x, y, 3}, {0.15, 0.15, 3}});
  }
  return scene;
}

// Two robots that come from either end and share the middle.
class StructureSearchTest : public ::testing::Test {
 protected:
  static Pose T_world_a() { return Pose::FromXyzRpy(0, 20, 1, 0.03, -0.05, 0.3); }
  static Pose T_world_b() { return Pose::FromXyzRpy(40, 20, 1, -0.04, 0.02, 2.9); }
  static Pose T_a_b() { return T_world_a().Inverse() * T_world_b(); }

  static void SetUpTestSuite() {
    const Scene wood = MakeWood();
    const auto survey = [&](double from, double to, const Pose& T_world_odom, unsigned seed) {
      return Survey(wood, {Way({{from, 20, 1}, {to, 20, 1}}, 15), T_world_odom, 0.02, seed});
    };
    a_ = new PreparedMap(survey(0, 25, T_world_a(), 1));
    b_ = new PreparedMap(survey(40, 15, T_world_b(), 2));
  }
  static void TearDownTestSuite() {
    delete a_;
    delete b_;
  }

  static inline const PreparedMap *a_ = nullptr, *b_ = nullptr;
};

TEST_F(StructureSearchTest, FindsAPlaceByItsTrunks) {
  std::vector<StageTime> stages;
  const auto candidates = SearchStructure(a_->whole().walls, b_->whole().walls, {}, &stages);
  ASSERT_FALSE(candidates.empty());
  const Pose error = T_a_b().Inverse() * candidates[0].T_a_b;
  EXPECT_LT(error.translation().norm(), 2);
  EXPECT_LT(RotationAngle(error), 4 * kRadPerDeg);
  EXPECT_EQ(candidates[0].source, GuessSource::kStructure);
  ASSERT_EQ(stages.size(), 1u);
  EXPECT_EQ(stages[0].stage, "structure");
  for (size_t i = 1; i < candidates.size(); ++i) {
    EXPECT_LE(candidates[i].score, candidates[i - 1].score);
  }
}

TEST_F(StructureSearchTest, IsRepeatable) {
  const auto once = SearchStructure(a_->whole().walls, b_->whole().walls, {}, nullptr);
  const auto again = SearchStructure(a_->whole().walls, b_->whole().walls, {}, nullptr);
  ASSERT_EQ(once.size(), again.size());
  for (size_t i = 0; i < once.size(); ++i) {
    EXPECT_TRUE(once[i].T_a_b.Matrix() == again[i].T_a_b.Matrix());
  }
}

TEST_F(StructureSearchTest, NothingComesOfEmptyMapsOrWhenToldToStop) {
  SessionMap empty;
  empty.session = SessionId("empty");
  const PreparedMap nothing(empty);
  EXPECT_TRUE(SearchStructure(nothing.whole().walls, b_->whole().walls, {}, nullptr).empty());
  EXPECT_TRUE(SearchStructure(a_->whole().walls, nothing.whole().walls, {}, nullptr).empty());
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(
      SearchStructure(a_->whole().walls, b_->whole().walls, stop.get_token(), nullptr).empty());
}

// Three storeys of one plan, each seen on its own level: a candidate for each of them.
TEST(StoreysTest, ACandidateIsTriedOnEveryStorey) {
  Scene house;
  for (int storey = 0; storey <= 3; ++storey) {
    house.boxes.push_back({{10, 5, 3.0 * storey - 0.1}, {10, 5, 0.1}});
    if (storey == 3) break;
    const double z = 3.0 * storey + 1.4;
    for (const double y : {0.0, 10.0}) house.boxes.push_back({{10, y, z}, {10, 0.1, 1.3}});
    for (const double x : {0.0, 20.0}) house.boxes.push_back({{x, 5, z}, {0.1, 5, 1.3}});
    house.boxes.push_back({{6, 7, z}, {0.1, 3, 1.3}});
    house.boxes.push_back({{13, 2.5, z}, {0.1, 2.5, 1.3}});
    // The box tells the storeys apart.
    house.boxes.push_back({{3.0 + 5 * storey, 8, 3.0 * storey + 0.6}, {0.5, 0.5, 0.6}});
  }
  std::vector<Eigen::Vector3d> everywhere;
  for (int storey = 0; storey < 3; ++storey) {
    for (const auto& at : Way({{2, 4, 0}, {18, 6, 0}}, 10)) {
      everywhere.push_back(at + Eigen::Vector3d(0, 0, 3.0 * storey + 1));
    }
  }
  const Pose T_world_b = Pose::FromXyzRpy(2, 5, 4, 0, 0, 0.4);
  const PreparedMap a(Survey(house, {everywhere, Pose(), 0.01, 1}));
  const PreparedMap b(Survey(house, {Way({{2, 5, 4}, {18, 4, 4}}, 10), T_world_b, 0.01, 2}));
  ASSERT_EQ(a.whole().walls.storeys().size(), 3u);
  EXPECT_NEAR(a.whole().walls.storeys()[1], 3, 0.3);
  EXPECT_EQ(b.whole().walls.storeys().size(), 1u);
  CandidateSearch search(a, b);
  std::vector<Hypothesis> found;
  std::vector<StageTime> stages;
  search.ByBirdsEye(&found, &stages);
  const bool right = std::any_of(found.begin(), found.end(), [&](const Hypothesis& h) {
    return (h.T_a_b.Inverse() * T_world_b).translation().norm() < 0.3;
  });
  EXPECT_TRUE(right) << found.size();
}

}  // namespace
}  // namespace isthmus::matching
