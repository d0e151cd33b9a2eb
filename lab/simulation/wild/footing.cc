#include "lab/simulation/wild/footing.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

namespace isthmus::simulation::wild {
namespace {

constexpr double kStepUpM = 0.35, kDropM = 3;
constexpr double kBeforeM = 0.5;

// The distance to what is solid from `from` along `by`, or its length if there is none.
double Free(const RayCaster& world, Eigen::Vector3d from, const Eigen::Vector3d& by) {
  constexpr double kPast = 0.01;
  const double reach = by.norm();
  double gone = 0;
  while (gone < reach) {
    const Ray ray{from.cast<float>(), by.normalized().cast<float>()};
    Hit hit;
    world.Cast({&ray, 1}, static_cast<float>(reach - gone), {&hit, 1});
    if (hit.range_m < 0) return reach;
    if (hit.material != Material::kLeaves) return gone + hit.range_m;
    gone += hit.range_m + kPast;
    from += (hit.range_m + kPast) * by.normalized();
  }
  return reach;
}

bool IsFree(const RayCaster& world, const Eigen::Vector3d& from, const Eigen::Vector3d& by) {
  return Free(world, from, by) >= by.norm();
}

// A ray may slip between two triangles, so there are two.
bool HasGround(const RayCaster& world, const Eigen::Vector3d& at) {
  constexpr double kReachM = 0.5;
  const Eigen::Vector3d down(0, 0, -2 * kReachM);
  return !IsFree(world, at + Eigen::Vector3d(0, 0, kReachM), down) ||
         !IsFree(world, at + Eigen::Vector3d(0.03, 0.02, kReachM), down);
}

// Nothing is between two places on the ground, over the carrier's width, and above the second.
bool CanGo(const RayCaster& world, const Carrier& carrier, const Eigen::Vector3d& from,
           const Eigen::Vector3d& to) {
  constexpr double kSteepest = 1, kWidest = 0.5;
  constexpr double kLintelM = 2;  // Rides go below doors that are lower than their sensor.
  const Eigen::Vector3d by = to - from;
  if (std::abs(by.z()) > kSteepest * by.head<2>().norm() || !HasGround(world, to)) return false;
  const Eigen::Vector3d left = Eigen::Vector3d(-by.y(), by.x(), 0).normalized();
  for (const double side : {-1, 0, 1}) {
    const Eigen::Vector3d aside = side * std::min(kWidest, carrier.base_m / 2) * left;
    for (const double high : {0.3, 0.8}) {
      if (!IsFree(world, from + aside + high * Eigen::Vector3d::UnitZ(), by)) return false;
    }
  }
  return IsFree(
      world, to + 0.3 * Eigen::Vector3d::UnitZ(),
      std::max(0.1, std::min(carrier.height_m, kLintelM) - 0.3) * Eigen::Vector3d::UnitZ());
}

}  // namespace

Path OnGround(const Path& path, const Carrier& carrier, const RayCaster& world) {
  std::vector<Eigen::Vector3d> points = path.points();
  std::vector<double> ground;
  double z = points.front().z();
  for (const Eigen::Vector3d& point : points) {
    const double depth = Free(world, {point.x(), point.y(), z + kStepUpM},
                              Eigen::Vector3d(0, 0, -kStepUpM - kDropM));
    if (depth < kStepUpM + kDropM) z += kStepUpM - depth;
    ground.push_back(z);
  }
  // A carrier is as high as its wheels or feet are on average.
  const auto reach = static_cast<std::ptrdiff_t>(std::lround(carrier.base_m / 2 / path.step_m()));
  const auto count = static_cast<std::ptrdiff_t>(points.size());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const auto from = ground.begin() + std::max<std::ptrdiff_t>(0, i - reach);
    const auto to = ground.begin() + std::min(count, i + reach + 1);
    points[static_cast<size_t>(i)].z() =
        std::accumulate(from, to, 0.0) / static_cast<double>(to - from);
  }
  return Path(std::move(points), path.step_m());
}

double FreeUntil(const Path& path, double begin_m, double end_m, const Carrier& carrier,
                 const RayCaster& world) {
  const double step = path.step_m();
  for (double s = begin_m; s < end_m; s += step) {
    const Eigen::Vector3d next = path.At(std::min(s + step, end_m)).position;
    if (CanGo(world, carrier, path.At(s).position, next)) continue;
    return std::clamp(s - kBeforeM, begin_m, end_m);
  }
  return end_m;
}

}  // namespace isthmus::simulation::wild
