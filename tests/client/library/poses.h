// A pose with nothing special about it, and its comparison after a way over the network.
#pragma once

#include <gtest/gtest.h>

#include "core/pose.h"

namespace isthmus::client {

inline const Pose kPose = Pose::FromXyzRpy(1, -2, 3, 0.1, -0.2, 2.5);

inline void ExpectEqual(const Pose& a, const Pose& b) {
  EXPECT_TRUE(a.Matrix().isApprox(b.Matrix(), 1e-12)) << a.Matrix() << "\n" << b.Matrix();
}

}  // namespace isthmus::client
