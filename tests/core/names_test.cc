// Names of values that are stored and printed.
#include <gtest/gtest.h>

#include "core/map/match.h"
#include "core/map/point_class.h"
#include "core/odometry_mode.h"

namespace isthmus {
namespace {

TEST(Names, OfReasonsAreReadAsTheyAreWritten) {
  for (int i = 0; i <= static_cast<int>(MatchReason::kUnverified); ++i) {
    const auto reason = static_cast<MatchReason>(i);
    EXPECT_EQ(ParseMatchReason(ToString(reason)), reason) << i;
  }
  EXPECT_EQ(ParseMatchReason("ENCLOSED"), MatchReason::kPossibleTwin) << "as it was once stored";
  EXPECT_STREQ(ToString(MatchReason::kPossibleTwin), "POSSIBLE_TWIN");
  EXPECT_EQ(ParseMatchReason("of a newer version"), MatchReason::kNone);
}

TEST(Names, OfGuessesAreReadAsTheyAreWritten) {
  for (int i = 0; i <= static_cast<int>(GuessSource::kByHand); ++i) {
    const auto source = static_cast<GuessSource>(i);
    EXPECT_EQ(ParseGuessSource(ToString(source)), source) << i;
  }
  EXPECT_EQ(ParseGuessSource("a dream"), GuessSource::kNone);
}

TEST(Names, OfPointClassesAreReadAsTheyAreWritten) {
  for (int i = 0; i < kPointClasses; ++i) {
    const auto point_class = static_cast<PointClass>(i);
    EXPECT_EQ(*ParsePointClass(ToString(point_class)), point_class) << i;
  }
  EXPECT_STREQ(ToString(PointClass::kUnknown), "unknown");
  EXPECT_STREQ(ToString(PointClass::kMover), "mover");
  EXPECT_STREQ(ToString(static_cast<PointClass>(kPointClasses)), "unknown");
  const absl::Status unknown = ParsePointClass("cheese").status();
  EXPECT_TRUE(absl::IsInvalidArgument(unknown));
  EXPECT_NE(unknown.message().find("vegetation"), absl::string_view::npos);
}

TEST(Names, OfOdometriesAreListedWhereOneIsUnknown) {
  for (const std::string& name : OdometryModeNames()) {
    const auto mode = ParseOdometryMode(name);
    ASSERT_TRUE(mode.ok()) << name;
    EXPECT_EQ(ToString(*mode), name);
  }
  const absl::Status unknown = ParseOdometryMode("dead reckoning").status();
  EXPECT_TRUE(absl::IsInvalidArgument(unknown));
  EXPECT_NE(unknown.message().find("continuous"), absl::string_view::npos);
}

}  // namespace
}  // namespace isthmus
