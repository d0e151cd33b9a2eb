#include "core/geometry/near_origin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace isthmus {
namespace {

using Eigen::Vector3d;

TEST(NearOrigin, WhatIsFarIsMovedByWholeKilometres) {
  EXPECT_EQ(ShiftToOrigin({691'234.5, -5'334'100, 520}), Vector3d(-691'000, 5'334'000, 0));
  EXPECT_EQ(ShiftToOrigin({-2001, 1999, 0}), Vector3d(2000, -1000, 0));
  EXPECT_TRUE(ShiftToOrigin({2000, -2000, 1999}).isZero());
  EXPECT_TRUE(ShiftToOrigin({std::nan(""), 1e6, 0}).isZero());
  EXPECT_TRUE(ShiftToOrigin({1e300, 0, 0}).isZero());
  EXPECT_FALSE(std::signbit(ShiftToOrigin({5000, 0.5, 0}).y()));
}

TEST(NearOrigin, OutliersDoNotMoveTheMiddle) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(MiddleOf({1, 3, 2, kInf, -kInf}, {5e6, 5e6, 0}, {}), Vector3d(2, 5e6, 0));
}

TEST(NearOrigin, TheTextHasWholeMetres) {
  EXPECT_EQ(ShiftText("A.las", {-691'000, 5'334'000, 0}),
            "A.las is far from its origin: -691000 5334000 0 m are added to its coordinates");
}

}  // namespace
}  // namespace isthmus
