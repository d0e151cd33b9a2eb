#include "client/report/advice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/report/server_states.h"

namespace isthmus::report {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(Advice, MapsApartHaveTheReasonAndWhatHelps) {
  const auto advice = WhatIsWaiting(TwoApart(MatchReason::kPossibleTwin));
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_THAT(advice[0].what,
              AllOf(HasSubstr("bob-1"), HasSubstr("POSSIBLE_TWIN"), HasSubstr("20 m2")));
  EXPECT_THAT(advice[0].todo, HasSubstr("isthmus anchor set"));
}

TEST(Advice, WhatHindersRobotsComesFirst) {
  ServerState state = TwoApart(MatchReason::kLowOverlap);
  state.info.storage_problem = "the disk is full";
  state.info.settled = false;
  state.sessions[0].lost_since_ns = 41'300'000'000;
  state.sessions[1].map_bytes = 2'000'000;
  state.sessions[1].quota_bytes = 1'000'000;
  const auto advice = WhatIsWaiting(state);
  ASSERT_EQ(advice.size(), 5u);
  EXPECT_THAT(advice[0].what, HasSubstr("the disk is full"));
  EXPECT_THAT(advice[1].what, HasSubstr("alice-1 is lost since stamp 41.300"));
  EXPECT_THAT(advice[2].what, HasSubstr("bob has stored 2.0 MB of 1.0 MB"));
  EXPECT_THAT(advice[4].what, HasSubstr("at work"));
}

TEST(Advice, NothingWaitsWhereAllIsInOneMap) {
  ServerState state = TwoApart(MatchReason::kOk);
  state.info.components.resize(1);
  EXPECT_TRUE(WhatIsWaiting(state).empty());
}

TEST(Advice, EveryReasonHasSome) {
  for (int reason = 0; reason <= static_cast<int>(MatchReason::kUnverified); ++reason) {
    EXPECT_GT(std::string(WhatToDo(static_cast<MatchReason>(reason))).size(), 20u);
  }
}

}  // namespace
}  // namespace isthmus::report
