// Events on their way to the store: nobody waits for it, and what is lost is said.
#include "server/map/event_journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/concurrency/event_count.h"
#include "server/map/limits.h"
#include "storage/memory_store.h"
#include "tests/storage/faulty_store.h"

namespace isthmus::server {
namespace {

using testing::ElementsAre;

Event Happening(EventKind kind, const std::string& text = "it happened") {
  Event event;
  event.kind = kind;
  event.text = text;
  return event;
}

class EventJournalTest : public testing::Test {
 protected:
  EventJournalTest()
      : store_(journal_.Watch(storage::MakeFaultyStore(storage::MakeMemoryStore(), faults_))) {}
  ~EventJournalTest() override { journal_.Stop(); }

  std::vector<Event> Stored() {
    return store_->ListEvents({.after = 0, .limit = 2 * kMaxWaitingEvents})->events;
  }
  std::vector<std::string> Texts() {
    std::vector<std::string> texts;
    for (const Event& event : Stored()) texts.push_back(event.text);
    return texts;
  }

  const std::shared_ptr<storage::Faults> faults_ = std::make_shared<storage::Faults>();
  ManualClock clock_{42};
  Mutex mutex_;
  std::vector<std::string> told_ ABSL_GUARDED_BY(mutex_);
  EventJournal journal_{&clock_, [this](const Event& event) {
                          MutexLock lock(&mutex_);
                          told_.push_back(event.text);
                        }};
  const std::unique_ptr<storage::MapStore> store_;
};

TEST_F(EventJournalTest, WhatIsAppendedIsStoredInOrderWithItsTime) {
  journal_.Start();
  journal_.Note(Happening(EventKind::kRobotLost, "first"));
  journal_.Note(Happening(EventKind::kRobotFound, "second"));
  journal_.WaitUntilStored();
  EXPECT_THAT(Texts(), ElementsAre("first", "second"));
  EXPECT_EQ(Stored()[0].time_ns, 42);
}

TEST_F(EventJournalTest, WhatWaitsIsStoredAtTheEnd) {
  journal_.Note(Happening(EventKind::kRobotLost));
  journal_.Start();
  journal_.Stop();
  journal_.Note(Happening(EventKind::kRobotLost));
  EXPECT_EQ(Stored().size(), 1u);
}

TEST_F(EventJournalTest, NobodyWaitsForAStoreThatStandsStill) {
  faults_->Stall();
  journal_.Start();
  for (size_t k = 0; k < 2 * kMaxWaitingEvents; ++k) {
    journal_.Note(Happening(EventKind::kRobotLost));
  }
  faults_->Resume();
  journal_.WaitUntilStored();
  const std::vector<Event> stored = Stored();
  // The newest are lost, and counted.
  ASSERT_FALSE(stored.empty());
  EXPECT_EQ(stored.back().kind, EventKind::kEventsLost);
  const size_t lost = 2 * kMaxWaitingEvents - (stored.size() - 1);
  EXPECT_THAT(stored.back().text, testing::HasSubstr(std::to_string(lost) + " events"));
  EXPECT_LE(stored.size(), kMaxWaitingEvents + kMaxEventsAtOnce + 1);
}

TEST_F(EventJournalTest, WhatCannotBeStoredIsStoredLater) {
  faults_->SetDiskFull(true);
  journal_.Start();
  journal_.Note(Happening(EventKind::kRobotLost, "first"));
  journal_.WaitUntilStored();  // It cannot be at the moment.
  EXPECT_TRUE(Stored().empty());
  EventCount stored;
  journal_.OnStored([&] { stored.Notify(); });
  faults_->SetDiskFull(false);
  stored.WaitPast(0);
  EXPECT_THAT(Texts(), ElementsAre("first"));
}

TEST_F(EventJournalTest, AnEventThatTheStoreRefusesHoldsUpNoOther) {
  journal_.Start();
  journal_.Note(Event());
  journal_.WaitUntilStored();
  journal_.Note(Happening(EventKind::kRobotLost, std::string(3 * kMaxEventText, 'x')));
  journal_.WaitUntilStored();
  ASSERT_EQ(Stored().size(), 1u);
  EXPECT_EQ(Stored()[0].text.size(), kMaxEventText);
}

TEST_F(EventJournalTest, TellsOfThoseInBatchesOnceTheyAreStored) {
  int woken = 0;
  const uint64_t handle = journal_.OnStored([&] { ++woken; });
  faults_->SetDiskFull(true);
  EXPECT_FALSE(store_->Write({.events = {Happening(EventKind::kDatumSet, "a")}}).ok());
  EXPECT_EQ(woken, 0);
  faults_->SetDiskFull(false);
  EXPECT_TRUE(store_->Write({.events = {Happening(EventKind::kDatumSet, "b")}}).ok());
  EXPECT_EQ(woken, 1);
  journal_.Forget(handle);
  EXPECT_TRUE(store_->Write({.events = {Happening(EventKind::kServerStarted, "c")}}).ok());
  EXPECT_EQ(woken, 1);
  MutexLock lock(&mutex_);
  EXPECT_THAT(told_, ElementsAre("b"));  // The log says more of a start elsewhere.
}

}  // namespace
}  // namespace isthmus::server
