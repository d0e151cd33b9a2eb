#include "server/classes/upright.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/server/classes/clouds.h"

namespace isthmus::classes {
namespace {

Cloud3 TurnedCloud(const Cloud3& cloud, const Eigen::Quaternionf& turn) {
  Cloud3 turned;
  for (const Eigen::Vector3f& p : cloud) turned.push_back(turn * p);
  return turned;
}

float DegreesBetween(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return 57.2958F * std::acos(std::min(a.dot(b), 1.0F));
}

TEST(UprightTest, ARoomTellsUpHoweverTheSensorLeans) {
  const Cloud3 room = Joined({RoomFloor(), RoomWalls()});
  for (const float degrees : {0.0F, 5.0F, 12.0F}) {
    const Eigen::Quaternionf turn(
        Eigen::AngleAxisf(degrees / 57.2958F, Eigen::Vector3f(1, 2, 0).normalized()));
    Moments moments(TurnedCloud(room, turn));
    const Eigen::Vector3f up = EstimateUp(&moments, {0, 0, 1});
    EXPECT_LT(DegreesBetween(up, turn * Eigen::Vector3f(0, 0, 1)), 1) << degrees;
  }
}

TEST(UprightTest, TheGuessStaysWhereLittleIsSeen) {
  const Eigen::Vector3f guess = Eigen::Vector3f(0.1F, 0, 1).normalized();
  Moments none(Cloud3{});
  EXPECT_EQ(EstimateUp(&none, guess), guess);
  Cloud3 few;
  AddPatch({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, &few);
  few.resize(30);
  Moments moments(few);
  EXPECT_EQ(EstimateUp(&moments, guess), guess);
}

}  // namespace
}  // namespace isthmus::classes
