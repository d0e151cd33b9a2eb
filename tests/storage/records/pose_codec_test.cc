#include "storage/records/pose_codec.h"

#include <gtest/gtest.h>

#include <random>

namespace isthmus::storage {
namespace {

// A session that is resumed compares what it was made with to the last bit.
TEST(PoseCodec, KeepsEveryBit) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(-3, 3);
  Pose pose;
  for (int k = 0; k < 2000; ++k) {
    pose = pose * Pose::FromXyzRpy(angle(random), angle(random), angle(random), angle(random),
                                   angle(random), angle(random));
    const Pose back = UnpackPose(PackPose(pose));
    EXPECT_EQ(back.rotation().coeffs(), pose.rotation().coeffs());
    EXPECT_EQ(back.translation(), pose.translation());
  }
}

TEST(PoseCodec, MakesAQuaternionThatIsNoneOne) {
  std::string bytes;
  for (const double q : {0.0, 0.0, 0.5, 0.5}) AppendBytes(q, bytes);
  for (int k = 0; k < 3; ++k) AppendBytes(1.0, bytes);
  EXPECT_NEAR(UnpackPose(bytes).rotation().norm(), 1, 1e-15);
  bytes.pop_back();
  EXPECT_EQ(UnpackPose(bytes).translation(), Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace isthmus::storage
