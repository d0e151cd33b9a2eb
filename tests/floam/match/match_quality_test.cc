#include "floam/match/match_quality.h"

#include <gtest/gtest.h>

namespace isthmus::floam {
namespace {

WallsSeen Walls(int onto, int through) { return {onto, through}; }

TEST(MatchQuality, WallsLookedThroughSpeakAgainstAPlaceByWhatIsUsualThere) {
  MatchQuality indoors, crowd;
  EXPECT_FALSE(indoors.IsContradicted(Walls(100, 900))) << "Nothing is known yet.";
  for (int i = 0; i < 20; ++i) {
    indoors.AddWalls(Walls(970, 30));
    crowd.AddWalls(Walls(300, 700));
  }
  EXPECT_FALSE(indoors.IsContradicted(Walls(850, 150)));
  EXPECT_TRUE(indoors.IsContradicted(Walls(700, 300)));
  EXPECT_FALSE(crowd.IsContradicted(Walls(200, 800)));
  EXPECT_TRUE(crowd.IsContradicted(Walls(20, 980)));
}

TEST(MatchQuality, FewWallsTellNothing) {
  MatchQuality quality;
  quality.AddWalls(Walls(0, 40));
  EXPECT_FALSE(quality.IsContradicted(Walls(0, 1000)));
  quality.AddWalls(Walls(1000, 0));
  EXPECT_EQ(quality.through(), 0);
  EXPECT_FALSE(quality.IsContradicted(Walls(0, 40)));
  EXPECT_TRUE(quality.IsContradicted(Walls(0, 1000)));
}

}  // namespace
}  // namespace isthmus::floam
