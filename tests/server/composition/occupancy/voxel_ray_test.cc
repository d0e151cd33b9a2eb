#include "server/composition/occupancy/voxel_ray.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace isthmus::composition {
namespace {

VoxelIndex IndexOf(const Eigen::Vector3d& p, double resolution_m) {
  return (p / resolution_m).array().floor().cast<int32_t>();
}

VoxelRay RayOf(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double resolution_m) {
  return {from, to, IndexOf(from, resolution_m), IndexOf(to, resolution_m), resolution_m};
}

// Every column that single steps enter, leaps enter at the same voxel.
void ExpectLeapsLikeSteps(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                          double resolution_m) {
  VoxelRay steps = RayOf(from, to, resolution_m), leaps = RayOf(from, to, resolution_m);
  while (!leaps.done()) {
    const ColumnKey column = ColumnOf(leaps.index());
    leaps.LeaveColumn();
    while (!steps.done() && ColumnOf(steps.index()) == column) steps.Step();
    ASSERT_EQ(steps.done(), leaps.done());
    if (steps.done()) break;
    ASSERT_EQ(steps.index(), leaps.index());
  }
  EXPECT_TRUE(steps.done());
}

TEST(VoxelRay, StepsGoToTheEndThroughNeighbours) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<double> at(-20, 20);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d from(at(rng), at(rng), at(rng)), to(at(rng), at(rng), at(rng));
    VoxelRay ray = RayOf(from, to, 0.1);
    while (!ray.done()) {
      const VoxelIndex before = ray.index();
      ray.Step();
      EXPECT_EQ((ray.index() - before).cwiseAbs().sum(), 1);
      // No voxel is farther from the line than half a diagonal.
      const Eigen::Vector3d middle = (ray.index().cast<double>().array() + 0.5) * 0.1;
      EXPECT_LT((middle - from).cross((to - from).normalized()).norm(), 0.0867);
    }
    EXPECT_EQ(ray.index(), IndexOf(to, 0.1));
  }
}

TEST(VoxelRay, LeapsLikeSteps) {
  std::mt19937 rng(2);
  std::uniform_real_distribution<double> at(-30, 30);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d from(at(rng), at(rng), at(rng)), to(at(rng), at(rng), at(rng));
    ExpectLeapsLikeSteps(from, to, i % 2 == 0 ? 0.1 : 0.07);
  }
}

// Rays that meet faces of several axes at once, or run along some.
TEST(VoxelRay, LeapsLikeStepsOnCornersAndEdges) {
  std::mt19937 rng(3);
  const auto at = [&rng] { return 0.25 * static_cast<double>(rng() % 257) - 32; };
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d from(at(), at(), at());
    Eigen::Vector3d to(at(), at(), at());
    if (i % 3 == 0) to.x() = from.x();
    if (i % 5 == 0) to.y() = from.y();
    if (i % 7 == 0) to.z() = from.z();
    if (i % 4 == 0) to = from + Eigen::Vector3d(8, -8, i % 8 == 0 ? 8 : 0);
    ExpectLeapsLikeSteps(from, to, i % 2 == 0 ? 0.25 : 0.125);
  }
}

}  // namespace
}  // namespace isthmus::composition
