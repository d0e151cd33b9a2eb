#include "server/matching/loops/loop_finder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>

#include "core/geometry/angles.h"
#include "server/matching/loops/loop_drift.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

using Submaps = std::vector<std::shared_ptr<const Submap>>;

// Through the gallery, back, and half way through it again: some 70 m.
std::vector<Eigen::Vector3d> ThereAndBack(double x = 0) {
  std::vector<Eigen::Vector3d> corners = {{3, 3, 1},   {10, 6, 1}, {14, 6, 1}, {20, 9, 1},
                                          {26, 10, 1}, {18, 8, 1}, {13, 6, 1}, {9, 4, 1},
                                          {3, 9, 1},   {3, 3, 1},  {10, 6, 1}, {14, 6, 1}};
  for (Eigen::Vector3d& corner : corners) corner.x() += x;
  return corners;
}

LoopOptions AfterTwentyMetres() {
  LoopOptions options;
  options.min_path_length_m = 20;
  return options;
}

std::vector<Pose> PosesOf(const Submaps& submaps) {
  std::vector<Pose> poses;
  for (const auto& submap : submaps) poses.push_back(submap->T_odom_submap);
  return poses;
}

// Asked after every submap, as they come; nothing is placed by what is found.
std::vector<LoopClosure> FindOneByOne(const Submaps& submaps, const LoopOptions& options) {
  LoopFinder finder(options);
  LoopQuery query;
  query.session = submaps.front()->id.session;
  for (const auto& submap : submaps) {
    query.first_new = query.submaps.size();
    query.submaps.push_back(submap);
    query.T_map_submap.push_back(submap->T_odom_submap);
    for (LoopClosure& closure : finder.Find(query)) query.known.push_back(std::move(closure));
  }
  return query.known;
}

// It is a closure of submaps in a row.
bool IsStep(const LoopClosure& closure) { return closure.submap_b - closure.submap_a <= 2; }

std::vector<LoopClosure> LoopsOf(std::vector<LoopClosure> found) {
  std::erase_if(found, IsStep);
  return found;
}

class LoopFinderTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const SessionMap map =
        Survey(MakeGallery(), {Way(ThereAndBack(), 55), Pose::FromXyzRpy(3, 3, 1, 0, 0, 0.3)});
    truth_ = map.submaps;
    // Half a metre and some degrees by the time it is back.
    strayed_ = Stray(truth_, Pose::FromXyzRpy(0.04, -0.05, 0.01, 0, 0, 0.008));
    all_ = FindOneByOne(strayed_, AfterTwentyMetres());
    found_ = LoopsOf(all_);
  }

  static const Submap& TruthOf(uint32_t index) { return *truth_.at(index); }
  static Pose Error(const SubmapEdge& edge) {
    return (TruthOf(edge.submap_a).T_odom_submap.Inverse() * TruthOf(edge.submap_b).T_odom_submap)
               .Inverse() *
           edge.T_a_b;
  }

  static inline Submaps truth_, strayed_;
  static inline std::vector<LoopClosure> all_, found_;  // found_: without steps.
};

// A damaged record, or covariances that rounding made negative: it ends.
TEST(LookBack, EndsWhateverThePosesAre) {
  for (const double at : {std::nan(""), 1e300, 9e7}) {
    std::vector<std::shared_ptr<const Submap>> submaps;
    std::vector<double> path_lengths;
    for (uint32_t k = 0; k < 6; ++k) {
      auto submap = std::make_shared<Submap>();
      submap->id = {SessionId("alice-1"), k};
      submap->T_odom_submap = Pose::FromXyzRpy(k % 2 == 0 ? at : -at, k, 0, 0, 0, 0.1 * k);
      submaps.push_back(submap);
      path_lengths.push_back(k);
    }
    EXPECT_EQ(LookBack(submaps, path_lengths, {}, {}).size(), 5u) << at;
  }
}

TEST_F(LoopFinderTest, ClosesTheLoopWhereItIs) {
  ASSERT_FALSE(found_.empty());
  std::set<uint32_t> closed;
  for (const LoopClosure& closure : found_) {
    closed.insert(closure.submap_b);
    for (const SubmapEdge& edge : closure.edges) {
      const Pose error = Error(edge);
      EXPECT_LT(error.translation().norm(), 0.02) << edge.submap_a << " " << edge.submap_b;
      EXPECT_LT(RotationAngle(error), 0.2 * kRadPerDeg) << edge.submap_a << " " << edge.submap_b;
    }
  }
  // Once closed it stays so: the last submaps all lie on older ones.
  for (uint32_t index = 8; index < truth_.size(); ++index) EXPECT_EQ(closed.count(index), 1u);
}

TEST_F(LoopFinderTest, FillsEveryField) {
  for (const LoopClosure& closure : found_) {
    EXPECT_EQ(closure.id, 0u);
    EXPECT_EQ(closure.session, truth_.front()->id.session);
    EXPECT_LT(closure.submap_a, closure.submap_b);
    ASSERT_FALSE(closure.edges.empty());
    EXPECT_LE(closure.edges.size(), AfterTwentyMetres().max_edges);
    EXPECT_EQ(closure.edges.front().submap_a, closure.submap_a);
    EXPECT_EQ(closure.edges.front().submap_b, closure.submap_b);
    EXPECT_TRUE(closure.edges.front().T_a_b.Matrix() == closure.T_a_b.Matrix());
    EXPECT_GT(closure.edges.front().information.trace(), 0);
    EXPECT_GT(closure.confidence, 0.5);
    EXPECT_LE(closure.confidence, 1);
    EXPECT_GT(closure.overlap, 0.3);
    EXPECT_GT(closure.residual_m, 0);
    EXPECT_LT(closure.residual_m, 0.1);
    EXPECT_GE(closure.free_space, 0);
    EXPECT_LE(closure.free_space, AfterTwentyMetres().max_free_space);
    EXPECT_GT(closure.comparisons, 500);
    EXPECT_NE(closure.source, GuessSource::kNone);
    EXPECT_FALSE(closure.detail.empty());
    EXPECT_FALSE(closure.rejected);
  }
}

TEST_F(LoopFinderTest, NoPairOfSubmapsTwice) {
  std::set<std::pair<uint32_t, uint32_t>> pairs;
  for (const LoopClosure& closure : found_) {
    for (const SubmapEdge& edge : closure.edges) {
      EXPECT_TRUE(pairs.emplace(edge.submap_a, edge.submap_b).second);
    }
  }
}

TEST_F(LoopFinderTest, IsDeterministic) {
  const std::vector<LoopClosure> again = FindOneByOne(strayed_, AfterTwentyMetres());
  ASSERT_EQ(again.size(), all_.size());
  for (size_t i = 0; i < again.size(); ++i) {
    ASSERT_EQ(again[i].edges.size(), all_[i].edges.size());
    EXPECT_EQ(again[i].submap_a, all_[i].submap_a);
    EXPECT_TRUE(again[i].T_a_b.Matrix() == all_[i].T_a_b.Matrix());
    EXPECT_EQ(again[i].confidence, all_[i].confidence);
  }
}

// As workers do, each of which may have searched for others, or for the session's beginning.
TEST_F(LoopFinderTest, WithTheMemoryOfAnotherFindsWhatThatWouldFind) {
  LoopFinder finders[] = {LoopFinder(AfterTwentyMetres()), LoopFinder(AfterTwentyMetres())};
  LoopMemory memory;
  LoopQuery query;
  query.session = strayed_.front()->id.session;
  for (size_t k = 0; k < strayed_.size(); ++k) {
    query.first_new = k;
    query.submaps.push_back(strayed_[k]);
    query.T_map_submap.push_back(strayed_[k]->T_odom_submap);
    LoopFinder fresh(AfterTwentyMetres());
    LoopFinder& finder = k % 3 == 2 ? fresh : finders[k % 3];
    finder.SetMemory(memory);
    for (LoopClosure& closure : finder.Find(query)) query.known.push_back(std::move(closure));
    memory = finder.memory();
  }
  ASSERT_EQ(query.known.size(), all_.size());
  for (size_t i = 0; i < all_.size(); ++i) {
    EXPECT_EQ(query.known[i].submap_a, all_[i].submap_a);
    EXPECT_EQ(query.known[i].submap_b, all_[i].submap_b);
    EXPECT_TRUE(query.known[i].T_a_b.translation() == all_[i].T_a_b.translation());
    EXPECT_EQ(query.known[i].detail, all_[i].detail);
  }
}

TEST_F(LoopFinderTest, NothingWhereTheWayIsShortOrNobodyAsks) {
  EXPECT_TRUE(LoopFinder(AfterTwentyMetres()).Find({}).empty());
  EXPECT_TRUE(FindOneByOne({strayed_.front()}, AfterTwentyMetres()).empty());
  EXPECT_TRUE(FindOneByOne({truth_.begin(), truth_.begin() + 3}, AfterTwentyMetres()).empty());
  LoopOptions options = AfterTwentyMetres();
  options.min_path_length_m = 1000;
  EXPECT_TRUE(LoopsOf(FindOneByOne(strayed_, options)).empty());
  options = AfterTwentyMetres();
  options.enabled = false;
  EXPECT_TRUE(FindOneByOne(strayed_, options).empty());
}

// Odometry that strays by some centimetres a submap is corrected from submap to submap; one that
// strays by less than submaps can be aligned is left alone.
TEST_F(LoopFinderTest, StepsOfABadOdometryAreCorrected) {
  std::set<uint32_t> corrected;
  for (const LoopClosure& closure : all_) {
    if (!IsStep(closure)) continue;
    EXPECT_TRUE(corrected.insert(closure.submap_b).second);
    EXPECT_LT(closure.submap_a, closure.submap_b);
    EXPECT_NE(closure.detail.find("Odometry errs by 0.0"), std::string::npos) << closure.detail;
    for (const SubmapEdge& edge : closure.edges) {
      EXPECT_EQ(edge.submap_b, closure.submap_b);
      EXPECT_LT(Error(edge).translation().norm(), 0.02) << edge.submap_a << " " << edge.submap_b;
      EXPECT_LT(RotationAngle(Error(edge)), 0.2 * kRadPerDeg);
    }
  }
  EXPECT_GE(4 * corrected.size(), 3 * (strayed_.size() - 1));  // Others share too little.
  for (const LoopClosure& closure : FindOneByOne(truth_, AfterTwentyMetres())) {
    EXPECT_FALSE(IsStep(closure)) << closure.detail;
  }
}

// A restart: an empty finder, and only the newest submap is asked for.
TEST_F(LoopFinderTest, GoesOnFromWhatWasFoundBefore) {
  LoopQuery query;
  query.session = strayed_.front()->id.session;
  query.submaps = strayed_;
  query.T_map_submap = PosesOf(strayed_);
  query.first_new = strayed_.size() - 1;
  for (const LoopClosure& closure : found_) {
    if (closure.submap_b + 1 < strayed_.size()) query.known.push_back(closure);
  }
  // It was placed by them.
  for (size_t i = 0; i + 1 < strayed_.size(); ++i) query.T_map_submap[i] = truth_[i]->T_odom_submap;
  const auto found = LoopsOf(LoopFinder(AfterTwentyMetres()).Find(query));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].submap_b, strayed_.size() - 1);
  EXPECT_LT(Error(found[0].edges.front()).translation().norm(), 0.02);
}

// A submap that was retired leaves a gap; those that are left are still named by their index.
TEST_F(LoopFinderTest, RetiredSubmapsAreNoTrouble) {
  Submaps left = strayed_;
  left.erase(left.begin() + 3);
  left.erase(left.begin());
  const std::vector<LoopClosure> found = FindOneByOne(left, AfterTwentyMetres());
  ASSERT_FALSE(found.empty());
  for (const LoopClosure& closure : found) {
    for (const SubmapEdge& edge : closure.edges) {
      EXPECT_NE(edge.submap_a, 0u);
      EXPECT_NE(edge.submap_a, 3u);
      EXPECT_LT(Error(edge).translation().norm(), 0.02);
    }
  }
}

TEST_F(LoopFinderTest, WhatAPersonRejectedIsNotOfferedAgain) {
  LoopQuery query;
  query.session = strayed_.front()->id.session;
  const LoopClosure& first = found_.front();
  query.known = {first};
  query.known.front().rejected = true;
  for (uint32_t i = 0; i <= first.submap_b; ++i) query.submaps.push_back(strayed_[i]);
  query.T_map_submap = PosesOf(query.submaps);
  query.first_new = first.submap_b;
  EXPECT_TRUE(LoopsOf(LoopFinder(AfterTwentyMetres()).Find(query)).empty());
  query.known.front().rejected = false;
  query.known.front().edges.clear();
  EXPECT_FALSE(LoopsOf(LoopFinder(AfterTwentyMetres()).Find(query)).empty());
}

// The same gallery once more, 45 m on: everything looks alike, but odometry knows better. If it
// claims to be back in the first one, the loop is closed.
TEST(LoopFinderTwinTest, ATwinIsAnotherPlaceIfOdometrySaysSo) {
  Scene scene = MakeGallery();
  for (SceneBox box : Scene(scene).boxes) {
    box.center.x() += 45;
    scene.boxes.push_back(box);
  }
  std::vector<Eigen::Vector3d> way = Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}}, 15);
  const auto twin = Way({{48, 3, 1}, {55, 6, 1}, {59, 6, 1}, {65, 9, 1}}, 15);
  way.insert(way.end(), twin.begin(), twin.end());
  const Submaps truth = Survey(scene, {way, Pose()}).submaps;
  const Pose stray = Pose::FromXyzRpy(0.05, 0.05, 0, 0, 0, 0.01);
  LoopOptions options = AfterTwentyMetres();
  options.min_path_length_m = 10;
  EXPECT_TRUE(LoopsOf(FindOneByOne(Stray(truth, stray), options)).empty());
  Submaps fooled;
  for (const auto& submap : truth) {
    auto moved = std::make_shared<Submap>(*submap);
    if (submap->id.index >= 3) {
      moved->T_odom_submap = Pose(Eigen::Vector3d(-45, 0, 0)) * moved->T_odom_submap;
    }
    fooled.push_back(std::move(moved));
  }
  EXPECT_FALSE(LoopsOf(FindOneByOne(Stray(fooled, stray), options)).empty());
}

// Other rooms than those seen before, as near as odometry may be off.
TEST(LoopFinderTwinTest, AnotherPlaceIsNotTheSame) {
  const Scene gallery = MakeGallery();
  Scene mirrored;
  for (SceneBox box : gallery.boxes) {
    box.center.x() = 30 - box.center.x();
    box.yaw = -box.yaw;
    mirrored.boxes.push_back(box);
  }
  const Submaps here =
      Survey(gallery,
             {Way({{3, 3, 1}, {10, 6, 1}, {14, 6, 1}, {20, 9, 1}, {26, 10, 1}}, 20), Pose()})
          .submaps;
  const Submaps there =
      Survey(mirrored,
             {Way({{27, 3, 1}, {20, 6, 1}, {16, 6, 1}, {10, 9, 1}, {4, 10, 1}}, 20), Pose()})
          .submaps;
  Submaps both = here;
  for (const auto& submap : there) {
    auto later = std::make_shared<Submap>(*submap);
    later->id.index += static_cast<uint32_t>(here.size());
    both.push_back(std::move(later));
  }
  LoopOptions options = AfterTwentyMetres();
  options.min_path_length_m = 10;
  EXPECT_TRUE(FindOneByOne(both, options).empty());
}

}  // namespace
}  // namespace isthmus::matching
