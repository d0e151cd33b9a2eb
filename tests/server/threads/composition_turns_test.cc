#include "server/threads/composition_turns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "server/threads/limits.h"

namespace isthmus::server {
namespace {

using ::testing::ElementsAre;

constexpr uint64_t kLarge = kTurnPoints + 1;

class CompositionTurnsTest : public ::testing::Test {
 protected:
  CompositionTurnsTest() { turns_.NoteShown({}); }

  void Place(const std::string& session, uint64_t points) {
    auto info = std::make_shared<SubmapInfo>();
    info->id = {SessionId(session), 0};
    info->point_count = points;
    placed_.push_back({info, 0, Pose()});
  }
  // The sessions of the next turn, which is shown.
  std::vector<std::string> Show() {
    const CompositionTurns::Turn turn = turns_.Next(placed_);
    EXPECT_EQ(turn.placed.size() + turn.waiting, placed_.size());
    turns_.NoteShown(turn);
    return SessionsOf(turn);
  }
  static std::vector<std::string> SessionsOf(const CompositionTurns::Turn& turn) {
    std::vector<std::string> sessions;
    for (const PlacedSubmap& p : turn.placed) sessions.push_back(p.submap->id.session.value());
    return sessions;
  }

  CompositionTurns turns_;
  std::vector<PlacedSubmap> placed_;
};

TEST_F(CompositionTurnsTest, OthersComeBeforeALargeOne) {
  Place("huge", kLarge);
  Place("alice", 200'000);
  Place("bob", 100'000);
  EXPECT_THAT(Show(), ElementsAre("alice", "bob"));
  EXPECT_THAT(Show(), ElementsAre("huge", "alice", "bob"));
  EXPECT_THAT(Show(), ElementsAre("huge", "alice", "bob"));
}

TEST_F(CompositionTurnsTest, LargeOnesComeOneByOneWithWhatIsNew) {
  for (const char* huge : {"huge1", "huge2", "huge3"}) Place(huge, kLarge);
  Place("alice", 10);
  EXPECT_THAT(Show(), ElementsAre("alice"));
  Place("bob", 10);
  EXPECT_THAT(Show(), ElementsAre("huge1", "alice", "bob"));
  Place("carol", 10);
  EXPECT_THAT(Show(), ElementsAre("huge1", "alice", "bob", "carol"));
  EXPECT_THAT(Show(), ElementsAre("huge1", "huge2", "alice", "bob", "carol"));
  EXPECT_EQ(Show().size(), 6u);
}

TEST_F(CompositionTurnsTest, WhoWaitsLongestIsNext) {
  Place("first", 3 * kLarge);
  Place("alice", 10);
  EXPECT_THAT(Show(), ElementsAre("alice"));
  Place("smaller", kLarge);
  EXPECT_THAT(Show(), ElementsAre("first", "alice"));
  EXPECT_EQ(Show().size(), 3u);
}

TEST_F(CompositionTurnsTest, ALargeOneGivesWayOnce) {
  Place("huge", kLarge);
  EXPECT_TRUE(turns_.Next(placed_).gives_way);
  Place("alice", 10);
  turns_.NoteGaveWay();
  EXPECT_THAT(Show(), ElementsAre("alice"));
  Place("bob", 10);
  const CompositionTurns::Turn turn = turns_.Next(placed_);
  EXPECT_THAT(SessionsOf(turn), ElementsAre("huge", "alice", "bob"));
  EXPECT_FALSE(turn.gives_way);
}

TEST_F(CompositionTurnsTest, ItGivesWayToWhatMovesNoMoreThanOnceEither) {
  Place("huge", kLarge);
  EXPECT_TRUE(turns_.Next(placed_).gives_way);
  turns_.NoteGaveWay();
  const CompositionTurns::Turn turn = turns_.Next(placed_);
  EXPECT_TRUE(turn.has_large);
  EXPECT_FALSE(turn.gives_way);
}

TEST_F(CompositionTurnsTest, ManyThatAreSmallComeInTurnsToo) {
  for (int i = 0; i < 7; ++i) Place("s" + std::to_string(i), kTurnPoints / 2);
  EXPECT_EQ(Show().size(), 2u);
  EXPECT_EQ(Show().size(), 5u) << "two more, and one that has waited";
  EXPECT_EQ(Show().size(), 7u);
}

TEST(CompositionTurns, WhatTheStoreHeldComesAtOnce) {
  CompositionTurns turns;
  auto info = std::make_shared<SubmapInfo>();
  info->point_count = kLarge;
  EXPECT_EQ(turns.Next({{info, 0, Pose()}, {info, 0, Pose()}}).placed.size(), 2u);
}

}  // namespace
}  // namespace isthmus::server
