#include "floam/track/tracker.h"

#include <gtest/gtest.h>

namespace isthmus::floam {
namespace {

// Nothing but one direction known by the map, everything by the scan before.
MatchResult Joined(const FeatureMap& map, const OdometryOptions& options) {
  MatchResult match;
  match.information(1, 1) = 1e6;
  match.degeneracy = FindDegeneracy(match.information, FreeMotion(options.matching));
  match.map_degeneracy = match.degeneracy;
  ScanToScanResult moved;
  moved.information = 1e6 * Matrix6d::Identity();
  JoinMotion(moved, options, map, &match);
  return match;
}

TEST(Join, TheScanBeforeTellsTheStepAndNotThePlaceInTheMap) {
  const OdometryOptions options;
  FeatureMap map(options);
  map.Resume({{{0, 0, 0}}}, Pose());
  ASSERT_FALSE(map.IsYoung());
  const MatchResult match = Joined(map, options);
  EXPECT_FALSE(match.degeneracy.any());
  EXPECT_EQ(match.map_degeneracy.translations.size(), 2u);
  EXPECT_EQ(match.map_degeneracy.rotations.size(), 3u);
}

TEST(Join, ItIsAsGoodAsTheMapWhileThatIsYoung) {
  const OdometryOptions options;
  const MatchResult match = Joined(FeatureMap(options), options);
  EXPECT_FALSE(match.degeneracy.any());
  EXPECT_FALSE(match.map_degeneracy.any());
}

}  // namespace
}  // namespace isthmus::floam
