// Patterns of names, and what callers may do.
#include "server/access/caller.h"

#include <gtest/gtest.h>

#include "server/access/methods.h"

namespace isthmus::access {
namespace {

TEST(Patterns, StarsStandForAnyCharacters) {
  EXPECT_TRUE(Matches("alice", "alice"));
  EXPECT_FALSE(Matches("alice", "alice2"));
  EXPECT_FALSE(Matches("alice", "Alice"));
  EXPECT_TRUE(Matches("*", ""));
  EXPECT_TRUE(Matches("cart-*", "cart-"));
  EXPECT_TRUE(Matches("cart-*", "cart-17"));
  EXPECT_FALSE(Matches("cart-*", "acart-17"));
  EXPECT_TRUE(Matches("*-3*b", "x-3-3ab"));
  EXPECT_FALSE(Matches("*-3*b", "x-3-3ac"));
  EXPECT_TRUE(Matches("a*a*a", "aaa"));
  EXPECT_FALSE(Matches("a*a*a", "aa"));
  EXPECT_FALSE(Matches("", "a"));
}

TEST(Patterns, OfAPatternOnlyWhereAllItStandsForIsIn) {
  EXPECT_TRUE(Matches("yard*", "yard-*"));
  EXPECT_TRUE(Matches("*", "*"));
  EXPECT_FALSE(Matches("yard-*", "yard*"));
  EXPECT_FALSE(Matches("yard", "*"));
}

TEST(Patterns, ManyStarsTakeNoLongTime) {
  const std::string stars = "*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*b";
  EXPECT_FALSE(Matches(stars, std::string(5000, 'a')));
}

TEST(Callers, FeedTheRobotsTheyAreFor) {
  const Caller robot{"t", Role::kRobot, {"alice", "cart-*"}, {"default"}};
  EXPECT_TRUE(robot.MayFeed(RobotId("alice")));
  EXPECT_TRUE(robot.MayFeed(RobotId("cart-9")));
  EXPECT_FALSE(robot.MayFeed(RobotId("bob")));
  const Caller reader{"t", Role::kReader, {}, {"default"}};
  EXPECT_FALSE(reader.MayFeed(RobotId("alice"))) << "it has no robots";
  EXPECT_TRUE(absl::IsPermissionDenied(AllowedMethod(reader, "StreamScans").status()));
  // A robot's that may read the map.
  const Caller both{"t", Role::kReader, {"alice"}, {"default"}};
  EXPECT_TRUE(both.MayFeed(RobotId("alice")));
  EXPECT_FALSE(both.MayFeed(RobotId("bob")));
  EXPECT_TRUE(AllowedMethod(both, "StreamScans").ok());
  EXPECT_TRUE(AllowedMethod(both, "ExportMap").ok());
  EXPECT_TRUE(absl::IsPermissionDenied(AllowedMethod(both, "DecideMatch").status()));
  EXPECT_TRUE(Caller().MayFeed(RobotId("anyone")));
}

TEST(Callers, AreKnownByTheOneRobotThatTheyAreFor) {
  EXPECT_EQ((Caller{"t", Role::kRobot, {"alice"}, {"default"}}.OnlyRobot()), RobotId("alice"));
  EXPECT_EQ((Caller{"t", Role::kReader, {"alice"}, {"default"}}.OnlyRobot()), RobotId("alice"));
  EXPECT_TRUE((Caller{"t", Role::kRobot, {"cart-*"}, {"default"}}.OnlyRobot().empty()));
  EXPECT_TRUE((Caller{"t", Role::kRobot, {"alice", "bob"}, {"default"}}.OnlyRobot().empty()));
  EXPECT_TRUE(Caller().OnlyRobot().empty());
}

TEST(Callers, OfAnUnknownMethodAreRefused) {
  EXPECT_EQ(FindMethod("NoSuchMethod"), nullptr);
  EXPECT_TRUE(absl::IsPermissionDenied(AllowedMethod(Caller(), "NoSuchMethod").status()));
  EXPECT_EQ(AllowedMethod(Caller(), "BackUp").value(), FindMethod("BackUp"));
}

}  // namespace
}  // namespace isthmus::access
