#include "core/ids.h"

#include <gtest/gtest.h>

#include <type_traits>
#include <unordered_set>

namespace isthmus {
namespace {

TEST(Ids, AreValues) {
  EXPECT_EQ(RobotId("alice"), RobotId("alice"));
  EXPECT_NE(RobotId("alice"), RobotId("bob"));
  EXPECT_LT(SessionId("alice-1"), SessionId("bob-1"));
  EXPECT_TRUE(RobotId().empty());
  EXPECT_FALSE(RobotId("alice").empty());
}

TEST(Ids, DoNotTurnIntoEachOther) {
  static_assert(!std::is_convertible_v<RobotId, SessionId>);
  static_assert(!std::is_constructible_v<SessionId, RobotId>);
  static_assert(!std::is_convertible_v<std::string, RobotId>);
}

TEST(Ids, SubmapsAreOrderedBySessionThenIndex) {
  const SubmapId a9{SessionId("a"), 9}, a10{SessionId("a"), 10}, b0{SessionId("b"), 0};
  EXPECT_LT(a9, a10);
  EXPECT_LT(a10, b0);
  EXPECT_EQ(ToString(a10), "a/10");
}

TEST(Ids, CanBeHashed) {
  const std::unordered_set<SubmapId> ids = {
      {SessionId("a"), 1}, {SessionId("a"), 2}, {SessionId("b"), 1}, {SessionId("a"), 1}};
  EXPECT_EQ(ids.size(), 3u);
}

}  // namespace
}  // namespace isthmus
