#include "server/matching/paper/feature_chain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::string> Names(const std::vector<StageTime>& stages) {
  std::vector<std::string> names;
  for (const StageTime& time : stages) {
    EXPECT_GE(time.ms, 0);
    names.push_back(time.stage);
  }
  return names;
}

class FeatureChainTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const Drive drive{Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}}, 15),
                      Pose(Eigen::Vector3d(3, 3, 1))};
    map_ = new SessionMap(Survey(MakeGallery(), drive));
  }
  static void TearDownTestSuite() { delete map_; }

  FeatureChainTest() { options_.ransac.iterations = 100000; }

  // The same map in an odom frame of its own.
  static SessionMap Moved(const Pose& T_moved_odom) {
    SessionMap moved;
    moved.session = SessionId("moved-1");
    for (const auto& submap : map_->submaps) {
      auto copy = std::make_shared<Submap>(*submap);
      copy->T_odom_submap = T_moved_odom * copy->T_odom_submap;
      moved.submaps.push_back(copy);
    }
    return moved;
  }

  static inline SessionMap* map_ = nullptr;
  FeatureChainOptions options_;
};

TEST_F(FeatureChainTest, FindsAMapInItselfUnderAnyTransform) {
  for (const Pose& T_b_a : {Pose::FromXyzRpy(50, -30, 3, 0.1, -0.08, 2.2),
                            Pose::FromXyzRpy(-7, 110, -2, 1.2, 0.3, -0.9)}) {
    std::vector<StageTime> stages;
    const auto candidates = SearchByFeatures(*map_, Moved(T_b_a), options_, &stages);
    ASSERT_FALSE(candidates.empty());
    EXPECT_EQ(candidates.front().source, GuessSource::kPaper);
    EXPECT_GE(candidates.front().score, options_.ransac.min_inliers);
    const Pose error = candidates.front().T_a_b * T_b_a;
    EXPECT_LT(error.translation().norm(), 0.3);
    EXPECT_LT(RotationAngle(error), 0.03);
    EXPECT_THAT(Names(stages), ElementsAre("voxel_filter", "outlier_removal", "normals", "harris",
                                           "fpfh", "correspondence", "ransac", "svd"));
  }
}

TEST_F(FeatureChainTest, FeaturesComputedOnceMatchAsTheSearchDoes) {
  const SessionMap moved = Moved(Pose::FromXyzRpy(5, 6, 0, 0, 0, 1));
  std::vector<StageTime> stages;
  const auto a = ComputeFeatures(*map_, options_, &stages);
  const auto b = ComputeFeatures(moved, options_, &stages);
  ASSERT_TRUE(a.ok() && b.ok());
  ASSERT_EQ(a->keypoints.size(), a->descriptors.size());
  const auto composed = MatchFeatures(*a, *b, options_, &stages);
  const auto searched = SearchByFeatures(*map_, moved, options_, &stages);
  ASSERT_EQ(composed.size(), searched.size());
  for (size_t i = 0; i < composed.size(); ++i) {
    EXPECT_EQ(composed[i].T_a_b.Matrix(), searched[i].T_a_b.Matrix());
    EXPECT_EQ(composed[i].score, searched[i].score);
  }
}

TEST_F(FeatureChainTest, NothingToFindInMapsWithoutStructure) {
  std::vector<StageTime> stages;
  const auto structured = ComputeFeatures(*map_, options_, &stages);
  ASSERT_TRUE(structured.ok());
  SessionMap hollow;
  hollow.submaps.push_back(std::make_shared<Submap>());
  auto flat_submap = std::make_shared<Submap>();
  flat_submap->keyframes.push_back({});
  for (float x = -5; x < 5; x += 0.2f) {
    for (float y = -5; y < 5; y += 0.2f) flat_submap->points.push_back({x, y, -1, 0, 0});
  }
  auto one_place = std::make_shared<Submap>(*flat_submap);
  one_place->points.assign(1000, {1, 2, 3, 0, 0});
  for (const SessionMap& other : {SessionMap{}, hollow, SessionMap{SessionId("f-1"), {flat_submap}},
                                  SessionMap{SessionId("o-1"), {one_place}}}) {
    const auto features = ComputeFeatures(other, options_, &stages);
    ASSERT_TRUE(features.ok());
    EXPECT_THAT(MatchFeatures(*structured, *features, options_, &stages), IsEmpty());
    EXPECT_THAT(MatchFeatures(*features, *structured, options_, &stages), IsEmpty());
    EXPECT_THAT(SearchByFeatures(other, other, options_, &stages), IsEmpty());
  }
}

}  // namespace
}  // namespace isthmus::matching
