#include "floam/match/motion_model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace isthmus::floam {
namespace {

constexpr double kScanS = 0.1;

// Matched to a millimetre and a milliradian.
Matrix6d Exact() { return 1e-6 * Matrix6d::Identity(); }

TEST(MotionModel, GrowsUncertainWithTime) {
  const MotionModel model;
  const Matrix6d one = model.Displacement(kScanS), ten = model.Displacement(10 * kScanS);
  EXPECT_NEAR(ten(0, 0) / one(0, 0), 1000, 1e-6);  // With the third power, the speed being known.
  EXPECT_GT(one(5, 5), 0);
}

// Between scans the acceleration is not known; the speed there follows from the positions.
TEST(MotionModel, SettlesWhereScansAreExact) {
  MotionModel model;
  for (int k = 0; k < 50; ++k) model.Update(kScanS, Exact());
  const double settled = model.Displacement(kScanS)(0, 0);
  for (int k = 0; k < 50; ++k) model.Update(kScanS, Exact());
  EXPECT_NEAR(model.Displacement(kScanS)(0, 0), settled, 1e-3 * settled);
  EXPECT_LT(settled, 0.05 * 0.05);
}

TEST(MotionModel, ForgetsHowFastItGoesWhereNothingIsObserved) {
  MotionModel model;
  for (int k = 0; k < 50; ++k) model.Update(kScanS, Exact());
  const double known = model.Displacement(kScanS)(0, 0);
  for (int k = 0; k < 50; ++k) {
    Matrix6d along_unobserved = Exact();
    along_unobserved(0, 0) = model.Displacement(kScanS)(0, 0);
    model.Update(kScanS, along_unobserved);
  }
  EXPECT_GT(model.Displacement(kScanS)(0, 0), 20 * known);
  EXPECT_LT(model.Displacement(kScanS)(1, 1), 2 * known);
}

// The known acceleration of a robot never allows more than the limit for any robot.
TEST(MotionModel, GoesOnAsSteadilyAsTheRobotWasSeenToDo) {
  const auto spread = [](double density) {
    MotionModel model;
    model.ExpectAcceleration(density);
    return Matrix6d(model.Displacement(kScanS));
  };
  const Matrix6d any = MotionModel().Displacement(kScanS);
  EXPECT_NEAR(spread(0.04)(0, 0), 4 * spread(0.01)(0, 0), 1e-12);
  EXPECT_GT(spread(0)(0, 0), 0);
  EXPECT_NEAR(spread(30)(0, 0), any(0, 0), 1e-12);
  EXPECT_NEAR(spread(0.01)(5, 5), any(5, 5), 1e-12);  // Turning is another thing.
  MotionModel model;
  model.ExpectAcceleration(0.01);
  model.ExpectAnything();
  EXPECT_TRUE(model.Displacement(kScanS).isApprox(any));
}

}  // namespace
}  // namespace isthmus::floam
