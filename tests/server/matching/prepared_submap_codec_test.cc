#include "server/matching/prepared/prepared_submap_codec.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "server/matching/prepared/limits.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

class PreparedSubmapCodecTest : public testing::Test {
 protected:
  PreparedSubmapCodecTest() {
    const SessionMap map =
        Survey(MakeGallery(), {Way({{3, 3, 1}, {9, 4, 1}}, 5), Pose(Eigen::Vector3d(3, 3, 1))});
    submap_ = map.submaps.front();
    prepared_ = std::make_shared<const PreparedSubmap>(submap_);
  }

  std::shared_ptr<const Submap> submap_;
  std::shared_ptr<const PreparedSubmap> prepared_;
};

// Somebody's whole drive in one submap: 65,535 views would take gigabytes.
TEST(PreparedSubmap, HasAtMostSoManyViewsSpreadOverTheWay) {
  Submap submap;
  submap.id = {SessionId("a-1"), 0};
  for (uint16_t k = 0; k < 20000; ++k) {
    Keyframe &keyframe = submap.keyframes.emplace_back();
    keyframe.T_submap_sensor = Pose(Eigen::Vector3d(2.0 * k, 0, 0));
    // Every second one has measured nothing.
    if (k % 2 == 0) submap.points.push_back({.x = 2.0F * k, .y = 3, .z = 0, .keyframe = k});
  }
  const PreparedSubmap prepared(std::make_shared<const Submap>(submap));
  EXPECT_LE(prepared.views().size(), kMaxViews);
  EXPECT_GT(prepared.views().size(), kMaxViews / 3);
  EXPECT_GT(prepared.views().back().T_submap_sensor.translation().x(), 39900);
}

TEST_F(PreparedSubmapCodecTest, GivesBackWhatWasKept) {
  const auto again = DecodePreparedSubmap(submap_, EncodePreparedSubmap(*prepared_));
  ASSERT_NE(again, nullptr);
  EXPECT_EQ(again->voxel_m(), prepared_->voxel_m());
  ASSERT_EQ(again->surface().size(), prepared_->surface().size());
  EXPECT_GT(again->surface().size(), 500u);
  for (size_t k = 0; k < again->surface().size(); ++k) {
    const SurfacePoint &x = again->surface()[k], &y = prepared_->surface()[k];
    EXPECT_LT((x.position - y.position).norm(), 0.002f);
    EXPECT_GT(x.normal.dot(y.normal), 0.9999f);
    EXPECT_NEAR(x.roughness, y.roughness, 0.003f);
  }
  ASSERT_EQ(again->views().size(), prepared_->views().size());
  for (size_t k = 0; k < again->views().size(); ++k) {
    const PreparedSubmap::View &x = again->views()[k], &y = prepared_->views()[k];
    EXPECT_TRUE(x.T_submap_sensor.Matrix().isApprox(y.T_submap_sensor.Matrix(), 1e-12));
    EXPECT_EQ(x.image.shortest_cm(), y.image.shortest_cm());
    EXPECT_EQ(x.image.longest_cm(), y.image.longest_cm());
  }
  EXPECT_NEAR(again->radius_m(), prepared_->radius_m(), 0.01);
  EXPECT_EQ(again->sample().empty(), prepared_->sample().empty());
}

TEST_F(PreparedSubmapCodecTest, AnEmptySubmapToo) {
  auto empty = std::make_shared<Submap>();
  empty->keyframes.push_back({});
  const PreparedSubmap prepared(empty);
  const auto again = DecodePreparedSubmap(empty, EncodePreparedSubmap(prepared));
  ASSERT_NE(again, nullptr);
  EXPECT_TRUE(again->surface().empty());
}

TEST_F(PreparedSubmapCodecTest, DamageIsNoticedAndNeverRead) {
  const std::string bytes = EncodePreparedSubmap(*prepared_);
  for (size_t size : {size_t{0}, size_t{7}, size_t{19}, size_t{20}, bytes.size() - 1}) {
    EXPECT_EQ(DecodePreparedSubmap(submap_, bytes.substr(0, size)), nullptr) << size;
  }
  EXPECT_EQ(DecodePreparedSubmap(submap_, bytes + "x"), nullptr);
  std::string counts = bytes;
  counts[12] = static_cast<char>(0xff);
  EXPECT_EQ(DecodePreparedSubmap(submap_, counts), nullptr);
  std::string poses = bytes;
  const size_t pose = 20 + 10 * prepared_->surface().size();
  poses.replace(pose, 8, std::string(8, '\xff'));
  EXPECT_EQ(DecodePreparedSubmap(submap_, poses), nullptr);
}

}  // namespace
}  // namespace isthmus::matching
