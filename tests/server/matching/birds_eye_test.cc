#include "server/matching/search/birds_eye.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/angles.h"
#include "server/matching/search/birds_eye_image.h"
#include "server/matching/search/fft_correlator.h"
#include "server/matching/search/gravity.h"
#include "server/matching/search/planar_pose.h"
#include "tests/server/matching/scene.h"
#include "tests/server/matching/whole_maps.h"

namespace isthmus::matching {
namespace {

// Two robots in one gallery, their start frames far apart and tilted, sharing the middle.
class BirdsEyeTest : public ::testing::Test {
 protected:
  static Pose T_world_a() { return Pose::FromXyzRpy(3, 3, 1, 0.09, -0.07, 0.3); }
  static Pose T_world_b() { return Pose::FromXyzRpy(27, 8, 1, -0.1, 0.05, -2.0); }
  static Pose T_a_b() { return T_world_a().Inverse() * T_world_b(); }

  static void SetUpTestSuite() {
    const Scene scene = MakeGallery();
    map_a_ = Survey(
        scene, {Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}}, 15), T_world_a(), 0.01, 1});
    map_b_ = Survey(
        scene, {Way({{27, 8, 1}, {18, 8, 1}, {13, 6, 1}, {9, 4, 1}}, 15), T_world_b(), 0.01, 2});
  }

  static inline SessionMap map_a_, map_b_;
};

// At coordinates where floats are metres apart nothing is found, and nothing is written beside the
// images.
TEST_F(BirdsEyeTest, CellsFarFromTheOriginStayInTheImage) {
  EXPECT_EQ(CellAt(-7.5f, 10), 0);
  EXPECT_EQ(CellAt(9.9f, 10), 9);
  EXPECT_EQ(CellAt(123.0f, 10), 9);
  EXPECT_EQ(CellAt(3e30f, 10), 9);
  BirdsEyeCells cells;
  cells.cell_m = 0.5;
  cells.center = {9e7f, -9e7f};
  cells.radius = 3;
  for (const float x : {-2.f, 0.f, 2.f}) {
    cells.walls.push_back({cells.center + Eigen::Vector2f(x, 8 * x), {1, 0}, 1});
    cells.free.push_back(cells.center + Eigen::Vector2f(8 * x, x));
  }
  const BirdsEyeImage image = MakeReferenceImage(cells, 1);
  FftCorrelator correlator(image, 14);
  EXPECT_GT(image.width, 0);
}

TEST_F(BirdsEyeTest, PutsTheRightPlaceFirst) {
  std::vector<StageTime> stages;
  const auto candidates = SearchBirdsEye(map_a_, map_b_, BirdsEyeOptions(), &stages);
  ASSERT_FALSE(candidates.empty());
  const Pose error = T_a_b().Inverse() * candidates[0].T_a_b;
  EXPECT_LT(error.translation().norm(), 0.6);
  EXPECT_LT(RotationAngle(error), 2.5 * kRadPerDeg);
  EXPECT_EQ(candidates[0].source, GuessSource::kBirdsEye);
  ASSERT_EQ(stages.size(), 1u);
  EXPECT_EQ(stages[0].stage, "birds_eye");
}

// A shift of exactly nothing lies in the corner of the field of scores.
TEST_F(BirdsEyeTest, FindsAMapOnItself) {
  const auto candidates = SearchBirdsEye(map_a_, map_a_, BirdsEyeOptions(), nullptr);
  ASSERT_FALSE(candidates.empty());
  EXPECT_LT(candidates[0].T_a_b.translation().norm(), 0.3);
  EXPECT_LT(RotationAngle(candidates[0].T_a_b), 1 * kRadPerDeg);
}

TEST_F(BirdsEyeTest, CandidatesAreOrderedLimitedAndRepeatable) {
  BirdsEyeOptions options;
  options.candidates = 4;
  const auto first = SearchBirdsEye(map_a_, map_b_, options, nullptr);
  const auto second = SearchBirdsEye(map_a_, map_b_, options, nullptr);
  ASSERT_LE(first.size(), 4u);
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].score, second[i].score);
    EXPECT_TRUE(first[i].T_a_b.Matrix() == second[i].T_a_b.Matrix());
    if (i > 0) {
      EXPECT_LE(first[i].score, first[i - 1].score);
    }
  }
}

TEST_F(BirdsEyeTest, NothingComesOfEmptyMaps) {
  SessionMap empty;
  empty.session = SessionId("empty");
  EXPECT_TRUE(SearchBirdsEye(empty, map_b_, BirdsEyeOptions(), nullptr).empty());
  EXPECT_TRUE(SearchBirdsEye(map_a_, empty, BirdsEyeOptions(), nullptr).empty());
}

// Two halls 6 km apart: at the usual cells the correlation would take gigabytes.
TEST_F(BirdsEyeTest, MapsThatSpreadFarAreSearchedCoarsely) {
  SessionMap far = map_a_;
  Submap away = *map_a_.submaps.front();
  away.id.index = 1000;
  away.T_odom_submap = Pose(Eigen::Vector3d(6000, 100, 0)) * away.T_odom_submap;
  far.submaps.push_back(std::make_shared<const Submap>(away));
  const WallMap a(far, SampleSurface(far, 0.25)), b(map_b_, SampleSurface(map_b_, 0.25));
  const SceneScale scale = PairScale(a, b);
  const double cell = CellThatFits(a, b, scale, 0.5);
  EXPECT_GE(cell, 3);
  const BirdsEyeCells a_cells = MakeBirdsEyeCells(a, scale, cell);
  const BirdsEyeCells b_cells = MakeBirdsEyeCells(b, scale, cell);
  ASSERT_FALSE(a_cells.walls.empty());
  EXPECT_LT(std::pow(2 * (a_cells.radius + b_cells.radius) / cell, 2), 4.2e6);
  BirdsEyeOptions options;
  options.yaw_step_rad = 45 * kRadPerDeg;
  for (const Candidate& candidate : SearchBirdsEye(a, b, options, nullptr)) {
    EXPECT_TRUE(candidate.T_a_b.IsFinite());
  }
  // An image that fits is looked at as finely as ever.
  EXPECT_EQ(CellThatFits(b, b, scale, 0.5), 0.5);
}

TEST_F(BirdsEyeTest, EndsWhenItIsToldTo) {
  std::stop_source source;
  source.request_stop();
  BirdsEyeOptions options;
  options.stop = source.get_token();
  EXPECT_TRUE(SearchBirdsEye(map_a_, map_b_, options, nullptr).empty());
}

TEST_F(BirdsEyeTest, LevelsTiltedMaps) {
  const WallMap walls(map_a_, SampleSurface(map_a_, 0.25));
  EXPECT_FALSE(walls.outdoors());
  // World's up in odom, and back to level.
  const Eigen::Vector3d up_odom = T_world_a().rotation().inverse() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up_level = walls.T_level_odom().rotation() * up_odom;
  EXPECT_LT(std::acos(up_level.z()), 0.5 * kRadPerDeg);
  // The sensor drives 1 m above the floor.
  for (const Eigen::Vector3f& sensor : walls.sensors()) {
    EXPECT_NEAR(sensor.z() - walls.ground().Height(sensor.x(), sensor.y()), 1.0, 0.15);
  }
}

TEST(GravityTest, KeepsOdomWhereNothingIsLevel) {
  std::vector<SurfacePoint> walls(200);
  for (size_t i = 0; i < walls.size(); ++i) {
    const float angle = 0.1f * static_cast<float>(i);
    walls[i].normal = {std::cos(angle), std::sin(angle), 0};
  }
  EXPECT_TRUE(EstimateLevel(walls).isApprox(Eigen::Quaterniond::Identity()));
}

TEST_F(BirdsEyeTest, FreeCellsAreNeverWalls) {
  const WallMap walls(map_a_, SampleSurface(map_a_, 0.25));
  const BirdsEyeCells cells = MakeBirdsEyeCells(walls, SceneScale::Indoors(), 0.25);
  ASSERT_GT(cells.walls.size(), 100u);
  ASSERT_GT(cells.free.size(), 1000u);
  for (const auto& free : cells.free) {
    for (const auto& wall : cells.walls) {
      EXPECT_GT((free - wall.position).cwiseAbs().maxCoeff(), 0.3f);
    }
  }
}

// The transform's value of a shift is the sum by hand, wrapped shifts included.
TEST(FftCorrelatorTest, EqualsTheSumOfProducts) {
  BirdsEyeImage reference;
  reference.width = 5;
  reference.rows = 4;
  for (auto& plane : reference.planes) plane.assign(20, 0.0f);
  reference.planes[BirdsEyeImage::kWall][2 * 5 + 3] = 2.0f;
  reference.planes[BirdsEyeImage::kFree][1 * 5 + 1] = -1.0f;
  FftCorrelator correlator(reference, 3);
  for (int round = 0; round < 2; ++round) {  // The planes are clean again after the first.
    const int width = correlator.width(), rows = correlator.rows();
    correlator.plane(BirdsEyeImage::kWall)[1 * width + 2] = 3.0f;
    correlator.plane(BirdsEyeImage::kFree)[2 * width + 2] = 5.0f;
    const float* scores = correlator.Correlate();
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < width; ++x) {
        float expected = 0;
        if (x == 3 - 2 && y == 2 - 1) expected += 6.0f;
        if (x == width + 1 - 2 && y == rows + 1 - 2) expected -= 5.0f;
        EXPECT_NEAR(scores[y * width + x], expected, 1e-4) << x << " " << y;
      }
    }
  }
}

TEST(PlacementTest, KeepsTheBestOfNeighbours) {
  const std::vector<PlanarPose> all = {
      {0.0, {0, 0}, 1}, {0.05, {0.5, 0}, 3}, {0.0, {9, 0}, 2}, {M_PI, {0.5, 0}, 1.5}};
  const auto kept = SuppressNeighbors(all, Eigen::Vector2d::Zero(), 2.0, 0.1, 10);
  ASSERT_EQ(kept.size(), 3u);
  EXPECT_EQ(kept[0].score, 3);
  EXPECT_EQ(kept[1].score, 2);
  EXPECT_EQ(kept[2].score, 1.5);
  EXPECT_EQ(SuppressNeighbors(all, Eigen::Vector2d::Zero(), 2.0, 0.1, 1).size(), 1u);
}

// Headings either side of +-180 degrees are neighbours too.
TEST(PlacementTest, HeadingsWrapRound) {
  const auto kept = SuppressNeighbors({{3.13, {0, 0}, 1}, {-3.13, {0, 0}, 2}},
                                      Eigen::Vector2d::Zero(), 1.0, 0.1, 10);
  EXPECT_EQ(kept.size(), 1u);
}

}  // namespace
}  // namespace isthmus::matching
