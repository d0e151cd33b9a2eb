#include <gtest/gtest.h>

#include "server/placement/placer.h"

namespace isthmus::placement {
namespace {

Placement Make(const std::string& session, const std::string& reference,
               std::vector<std::pair<uint32_t, double>> submaps) {
  Placement placement{SessionId(session), 0, SessionId(reference), Pose()};
  for (const auto& [index, x] : submaps) {
    placement.submaps.push_back({index, Pose(Eigen::Vector3d(x, 0, 0))});
  }
  return placement;
}

TEST(FindMoves, TellsWhatCameMovedAndLeft) {
  const std::vector<SubmapMove> moves =
      FindMoves({Make("a-1", "a-1", {{0, 0}, {1, 1}, {2, 2}}), Make("b-1", "a-1", {{0, 5}})},
                {Make("a-1", "a-1", {{0, 0}, {2, 2.5}, {3, 3}}), Make("b-1", "b-1", {{0, 5}})});
  ASSERT_EQ(moves.size(), 4u);
  EXPECT_EQ(ToString(moves[0].submap), "a-1/1");
  EXPECT_TRUE(moves[0].before && !moves[0].after);
  EXPECT_EQ(moves[0].frame_before, SessionId("a-1"));
  EXPECT_TRUE(moves[0].frame_after.empty());
  EXPECT_EQ(ToString(moves[1].submap), "a-1/2");
  EXPECT_EQ(moves[1].before->translation().x(), 2);
  EXPECT_EQ(moves[1].after->translation().x(), 2.5);
  EXPECT_EQ(ToString(moves[2].submap), "a-1/3");
  EXPECT_TRUE(!moves[2].before && moves[2].after);
  // The same numbers in another map frame are another place.
  EXPECT_EQ(ToString(moves[3].submap), "b-1/0");
  EXPECT_EQ(moves[3].frame_before, SessionId("a-1"));
  EXPECT_EQ(moves[3].frame_after, SessionId("b-1"));
}

TEST(FindMoves, OfNothingIsNothing) {
  EXPECT_TRUE(FindMoves({}, {}).empty());
  const std::vector<Placement> some = {Make("a-1", "a-1", {{0, 0}, {1, 1}})};
  EXPECT_TRUE(FindMoves(some, some).empty());
  EXPECT_EQ(FindMoves({}, some).size(), 2u);
  EXPECT_EQ(FindMoves(some, {}).size(), 2u);
}

}  // namespace
}  // namespace isthmus::placement
