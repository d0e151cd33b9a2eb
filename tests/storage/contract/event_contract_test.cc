// The promises of map_store.h about events, held by every store.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/storage/contract/map_store_contract.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;
using ::testing::ElementsAre;

class EventContract : public MapStoreContract {
 protected:
  EventPage List(const EventQuery& query = {}) {
    const auto page = store_->ListEvents(query);
    EXPECT_TRUE(page.ok()) << page.status();
    return page.ok() ? *page : EventPage();
  }
  std::vector<uint64_t> Numbers(const EventQuery& query) {
    std::vector<uint64_t> numbers;
    for (const Event& event : List(query).events) numbers.push_back(event.number);
    return numbers;
  }
};

TEST_P(EventContract, IsEmptyAtFirst) {
  const EventPage page = List();
  EXPECT_TRUE(page.events.empty());
  EXPECT_EQ(page.newest, 0u);
  EXPECT_EQ(page.first_kept, 1u);
  EXPECT_EQ(page.up_to, 0u);
}

TEST_P(EventContract, EventsComeBackAsTheyWereWithNumbers) {
  Event event = MakeEvent(EventKind::kMatchDecided, 42);
  event.actor = {"chief", "ipv4:10.0.0.7:4711", "deploy-12"};
  event.robot = RobotId("alice");
  event.session = alice_;
  event.text = "match alice-1 ~ bob-1: REJECT (\"a note\nwith a line\")";
  event.number = 77;  // Not looked at.
  Put({.events = {event}});
  event.number = 1;
  EXPECT_THAT(List().events, ElementsAre(event));
}

TEST_P(EventContract, NumbersHaveNoGapsWhateverFails) {
  Put({.events = {MakeEvent(EventKind::kRobotLost, 1), MakeEvent(EventKind::kRobotFound, 2)}});
  // A refused batch changes nothing.
  EXPECT_EQ(CodeOf({.anchors = {MakeAnchor("nobody-1", 0)},
                    .events = {MakeEvent(EventKind::kAnchorSet, 3)}}),
            StatusCode::kFailedPrecondition);
  EXPECT_EQ(store_->DeleteSession(nobody_, {MakeEvent(EventKind::kSessionDeleted, 4)}).code(),
            StatusCode::kNotFound);
  Put({.events = {MakeEvent(EventKind::kLoopClosed, 5)}});
  EXPECT_THAT(Numbers({}), ElementsAre(1, 2, 3));
}

TEST_P(EventContract, GoesWithTheSessionThatIsDeleted) {
  Put({.sessions = {MakeSession("alice-1")}});
  ASSERT_TRUE(store_->DeleteSession(alice_, {MakeEvent(EventKind::kSessionDeleted, 9)}).ok());
  ASSERT_EQ(List().events.size(), 1u);
  EXPECT_EQ(List().events[0].kind, EventKind::kSessionDeleted);
}

TEST_P(EventContract, GivesTheFirstAfterANumberElseTheNewest) {
  for (int64_t i = 1; i <= 6; ++i) Put({.events = {MakeEvent(EventKind::kLoopClosed, i)}});
  EXPECT_THAT(Numbers({.limit = 2}), ElementsAre(5, 6));
  EXPECT_THAT(Numbers({.after = 0, .limit = 2}), ElementsAre(1, 2));
  EXPECT_THAT(Numbers({.after = 2, .limit = 2}), ElementsAre(3, 4));
  EXPECT_EQ(List({.after = 2, .limit = 2}).up_to, 4u);
  EXPECT_EQ(List({.after = 4, .limit = 9}).up_to, 6u);
  EXPECT_THAT(Numbers({.after = 6}), ElementsAre());
  EXPECT_EQ(List({.after = 6}).up_to, 6u);
  EXPECT_THAT(Numbers({.after = UINT64_MAX}), ElementsAre());
}

TEST_P(EventContract, FiltersByTimeKindAndRobot) {
  Event alice = MakeEvent(EventKind::kRobotLost, 10), bob = MakeEvent(EventKind::kRobotLost, 20),
        loop = MakeEvent(EventKind::kLoopClosed, 30);
  alice.robot = loop.robot = RobotId("alice");
  bob.robot = RobotId("bob");
  Put({.events = {alice, bob, loop}});
  EXPECT_THAT(Numbers({.since_ns = 20}), ElementsAre(2, 3));
  EXPECT_THAT(Numbers({.kinds = {EventKind::kRobotLost}}), ElementsAre(1, 2));
  EXPECT_THAT(Numbers({.kinds = {EventKind::kRobotLost, EventKind::kLoopClosed}}),
              ElementsAre(1, 2, 3));
  EXPECT_THAT(Numbers({.robot = RobotId("alice")}), ElementsAre(1, 3));
  EXPECT_THAT(Numbers({.after = 0, .kinds = {EventKind::kLoopClosed}, .robot = RobotId("bob")}),
              ElementsAre());
  // None that fits is behind what was looked at.
  EXPECT_EQ(List({.after = 0, .kinds = {EventKind::kLoopClosed}, .limit = 5}).up_to, 3u);
}

TEST_P(EventContract, KeepsTheNewest) {
  const std::vector<Event> many(kEventsKept, MakeEvent(EventKind::kLoopClosed, 1));
  Put({.events = many});
  Put({.events = {3, MakeEvent(EventKind::kRobotLost, 2)}});
  const EventPage page = List({.after = 0, .limit = 1});
  EXPECT_EQ(page.newest, kEventsKept + 3);
  EXPECT_EQ(page.first_kept, 4u);
  EXPECT_EQ(page.events.at(0).number, 4u);
  EXPECT_THAT(Numbers({.kinds = {EventKind::kRobotLost}}),
              ElementsAre(kEventsKept + 1, kEventsKept + 2, kEventsKept + 3));
}

TEST_P(EventContract, RefusesWhatIsNoEvent) {
  EXPECT_EQ(CodeOf({.events = {Event()}}), StatusCode::kInvalidArgument);
  Event endless = MakeEvent(EventKind::kRobotLost, 1);
  endless.text.assign(kMaxEventText + 1, 'x');
  EXPECT_EQ(CodeOf({.events = {endless}}), StatusCode::kInvalidArgument);
  Put({.sessions = {MakeSession("alice-1")}});
  EXPECT_EQ(store_->DeleteSession(alice_, {Event()}).code(), StatusCode::kInvalidArgument);
  EXPECT_TRUE(store_->GetSession(alice_).ok());
}

TEST(EventKinds, NamesLeadBack) {
  for (const EventKind kind : AllEventKinds()) EXPECT_EQ(ParseEventKind(ToString(kind)), kind);
  EXPECT_EQ(AllEventKinds().size(), static_cast<size_t>(EventKind::kEventsLost));
  EXPECT_EQ(ParseEventKind("NEWER"), EventKind::kUnknown);
}

INSTANTIATE_TEST_SUITE_P(Stores, EventContract, ::testing::ValuesIn(StoresOfContract()), NameOf);

}  // namespace
}  // namespace isthmus::storage
