#include "client/console/reason_tally.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isthmus::cli {
namespace {

TEST(ReasonTally, TheFirstFewOfAKindAreSaidAndTheRestCounted) {
  ReasonTally tally;
  int said = 0;
  for (int i = 0; i < 100; ++i) {
    said += tally.Count("dir/" + std::to_string(i) + ".pcd: no points") ? 1 : 0;
  }
  EXPECT_EQ(said, 3);
  EXPECT_TRUE(tally.Count("another one"));
  EXPECT_THAT(tally.Unsaid(),
              testing::ElementsAre(testing::Pair("dir/99.pcd: no points", uint64_t{97})));
}

}  // namespace
}  // namespace isthmus::cli
