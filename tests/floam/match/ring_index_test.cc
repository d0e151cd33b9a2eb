#include "floam/match/ring_index.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace isthmus::floam {
namespace {

constexpr float kReachM = 5;

// Rings as a sensor's, but points at random along each and ranges from 0.5 to 20 m.
std::vector<TimedPoint> RandomScan(int rings, int per_ring, std::mt19937* random) {
  std::uniform_real_distribution<float> azimuth(-3.2F, 3.2F), range(0.5F, 20),
      wobble(-0.01F, 0.01F);
  std::vector<TimedPoint> points;
  for (int ring = 0; ring < rings; ++ring) {
    for (int k = 0; k < per_ring; ++k) {
      const float a = azimuth(*random), r = range(*random);
      const float e = 0.04F * static_cast<float>(ring) - 0.3F + wobble(*random);
      points.push_back(
          {r * Eigen::Vector3f(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)),
           0, 1, static_cast<uint16_t>(ring)});
    }
  }
  return points;
}

// Distance to the nearest point for which `wanted` holds, up to kReachM.
template <typename Wanted>
float Nearest(const std::vector<TimedPoint>& points, const Eigen::Vector3f& q, Wanted wanted) {
  float best = kReachM;
  for (const TimedPoint& p : points) {
    if (wanted(p)) best = std::min(best, (p.position - q).norm());
  }
  return best;
}

TEST(RingIndex, FindsWhatLookingAtEveryPointFinds) {
  std::mt19937 random(3);
  const std::vector<TimedPoint> points = RandomScan(16, 120, &random);
  RingIndex index;
  index.Build(points);
  ASSERT_EQ(index.size(), points.size());
  std::uniform_real_distribution<float> uniform(-20, 20), height(-6, 6);
  int found_some = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    Eigen::Vector3f q(uniform(random), uniform(random), height(random));
    if (trial % 4 == 0) q = 0.02F * q;          // Near the axis, where azimuths mean little.
    if (trial % 7 == 0) q.y() = 1e-4F * q.y();  // Near the seam of the turn.
    const RingIndex::Query query(q);
    const auto nearest = index.Nearest(query, kReachM);
    const float expected = Nearest(points, q, [](const TimedPoint&) { return true; });
    ASSERT_EQ(nearest.index == RingIndex::kNone, expected == kReachM);
    if (nearest.index == RingIndex::kNone) continue;
    ++found_some;
    EXPECT_NEAR(std::sqrt(nearest.distance2), expected, 1e-3);
    const TimedPoint& at = index.At(nearest.index);
    EXPECT_NEAR((at.position - q).norm(), expected, 1e-3);
    // The next nearest on the same ring.
    RingIndex::Neighbour next;
    next.distance2 = kReachM * kReachM;
    index.NearestOnRing(query, at.ring, nearest.index, &next);
    const float beside = Nearest(points, q, [&](const TimedPoint& p) {
      return p.ring == at.ring && p.position != at.position;
    });
    EXPECT_NEAR(std::sqrt(next.distance2), beside, 1e-3);
    if (next.index != RingIndex::kNone) {
      EXPECT_EQ(index.At(next.index).ring, at.ring);
    }
  }
  EXPECT_GT(found_some, 1000);
}

TEST(RingIndex, RingsMayBeMissingAndReachIsKept) {
  RingIndex index;
  index.Build({{{5, 0, 0}, 0, 1, 3}, {{5, 1, 0}, 0, 1, 3}, {{5, 0, 2}, 0, 1, 9}});
  const RingIndex::Query query({5, 0.1F, 0});
  EXPECT_EQ(index.At(index.Nearest(query, 1).index).position, Eigen::Vector3f(5, 0, 0));
  EXPECT_EQ(index.Nearest(query, 0.05F).index, RingIndex::kNone);
  for (const int missing : {-1, 0, 5, 10, 1000}) {
    RingIndex::Neighbour none;
    index.NearestOnRing(query, missing, RingIndex::kNone, &none);
    EXPECT_EQ(none.index, RingIndex::kNone) << missing;
  }
  index.Build({});
  EXPECT_EQ(index.Nearest(query, 100).index, RingIndex::kNone);
}

TEST(RingIndex, GoesAlongARingAsFarAsItReaches) {
  std::vector<TimedPoint> points;
  for (int k = 0; k < 20; ++k) {
    const float y = 0.1F * static_cast<float>(k) - 1 + (k >= 15 ? 3 : 0);  // A leap after 0.4.
    points.push_back({{4, y, 0}, 0, 1, 2});
  }
  RingIndex index;
  index.Build(points);
  const auto middle = index.Nearest(RingIndex::Query({4, 0, 0}), kReachM);
  const auto [left, right] = index.Along(middle.index, 0.75F);
  EXPECT_NEAR(index.At(left).position.y(), -0.7, 1e-5);
  EXPECT_NEAR(index.At(right).position.y(), 0.4, 1e-5);
}

}  // namespace
}  // namespace isthmus::floam
