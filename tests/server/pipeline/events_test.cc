// The event log of a pipeline: it has all changes of the map, with their authors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <string>

#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const Actor kChief{"chief", "ipv4:10.0.0.7:4711", "deploy-12"};

// Two robots that have seen one bare wall each, and nothing more: too little for any match.
void AddTwoWalls(Pipeline& pipeline) {
  for (const RobotId& robot : {kAlice, kBob}) {
    Submap submap;
    submap.id = {pipeline.sessions().Create({robot, "vlp16"}).value().record.id, 0};
    submap.keyframes = {{0, 1'000, Pose()}, {0, 2'000, Pose(Eigen::Vector3d(1, 0, 0))}};
    for (int i = 0; i < 400; ++i) {
      submap.points.push_back({3.f, 0.2f * (i % 20), 0.2f * (i / 20), 1.f, uint16_t(i % 2)});
    }
    ASSERT_TRUE(pipeline.sessions().AddSubmap(submap).ok());
  }
  pipeline.WaitUntilIdle();
}

std::vector<Event> EventsOf(Pipeline& pipeline, const std::vector<EventKind>& kinds) {
  pipeline.WaitUntilIdle();
  return pipeline.events().List({.kinds = kinds}).value().events;
}

std::vector<EventKind> KindsOf(Pipeline& pipeline) {
  std::vector<EventKind> kinds;
  for (const Event& event : EventsOf(pipeline, {})) kinds.push_back(event.kind);
  return kinds;
}

TEST(PipelineEvents, SessionsComeAndGoByName) {
  const auto pipeline = OpenInMemory();
  const SessionId session =
      pipeline->sessions().Create({kAlice, "vlp16"}, kChief).value().record.id;
  ASSERT_TRUE(pipeline->sessions().Finish(session, kChief).ok());
  ASSERT_TRUE(pipeline->sessions().Finish(session, kChief).ok());  // Nothing happens.
  ASSERT_TRUE(pipeline->sessions().Delete(session, kChief).ok());
  EXPECT_THAT(KindsOf(*pipeline),
              ElementsAre(EventKind::kSessionOpened, EventKind::kSessionFinished,
                          EventKind::kSessionDeleted));
  for (const Event& event : EventsOf(*pipeline, {})) {
    EXPECT_EQ(event.actor, kChief);
    EXPECT_EQ(event.robot, kAlice);
    EXPECT_EQ(event.session, session);
    EXPECT_THAT(event.text, HasSubstr("alice-1"));
  }
}

TEST(PipelineEvents, ADecisionNamesWhoMadeItAndWhatCameOfIt) {
  const auto pipeline = OpenInMemory();
  AddTwoWalls(*pipeline);
  MatchDecision decision;
  decision.robot_a = kAlice;
  decision.robot_b = kBob;
  decision.kind = ManualDecisionKind::kSet;
  decision.note = "by tape";
  ASSERT_TRUE(pipeline->decisions().DecideMatch(decision, kChief).ok());
  const auto decided = EventsOf(*pipeline, {EventKind::kMatchDecided});
  ASSERT_EQ(decided.size(), 1u);
  EXPECT_EQ(decided[0].actor, kChief);
  EXPECT_THAT(decided[0].text, HasSubstr("alice-1 ~ bob-1 by hand: SET; note: by tape"));
  const auto accepted = EventsOf(*pipeline, {EventKind::kMatchAccepted});
  ASSERT_EQ(accepted.size(), 1u);
  EXPECT_THAT(accepted[0].text, HasSubstr("joins"));
  EXPECT_GT(accepted[0].number, decided[0].number);

  decision.kind = ManualDecisionKind::kReject;
  ASSERT_TRUE(pipeline->decisions().DecideMatch(decision, kChief).ok());
  const auto lost = EventsOf(*pipeline, {EventKind::kMatchLost});
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_THAT(lost[0].text, HasSubstr("alice-1 ~ bob-1"));
  // Nothing is lost that was not there.
  decision.kind.reset();
  ASSERT_TRUE(pipeline->decisions().DecideMatch(decision, kChief).ok());
  EXPECT_EQ(EventsOf(*pipeline, {EventKind::kMatchLost}).size(), 1u);
}

TEST(PipelineEvents, PlacesAreGivenAndTakenBack) {
  const auto pipeline = OpenInMemory();
  AddTwoWalls(*pipeline);
  Anchor anchor;
  anchor.submap = {SessionId("alice-1"), 0};
  anchor.sigma_xy_m = anchor.sigma_z_m = anchor.sigma_deg = 1;
  ASSERT_TRUE(pipeline->decisions().PutAnchor(anchor, kChief).ok());
  ASSERT_TRUE(pipeline->decisions().RemoveAnchor(anchor.submap, kChief).ok());
  EXPECT_FALSE(pipeline->decisions().RemoveAnchor(anchor.submap, kChief).ok());
  ASSERT_TRUE(pipeline->decisions()
                  .SetDatum(Datum{.latitude_deg = 47.1, .longitude_deg = 8.5}, kChief)
                  .ok());
  ASSERT_TRUE(pipeline->decisions().SetDatum(std::nullopt, kChief).ok());
  const auto events =
      EventsOf(*pipeline, {EventKind::kAnchorSet, EventKind::kAnchorRemoved, EventKind::kDatumSet});
  ASSERT_EQ(events.size(), 4u);
  EXPECT_EQ(events[0].kind, EventKind::kAnchorSet);
  EXPECT_EQ(events[0].robot, kAlice);
  EXPECT_THAT(events[0].text, HasSubstr("alice-1/0"));
  EXPECT_EQ(events[1].kind, EventKind::kAnchorRemoved);
  EXPECT_THAT(events[2].text, HasSubstr("47.1"));
  EXPECT_THAT(events[3].text, HasSubstr("removed"));
  for (const Event& event : events) EXPECT_EQ(event.actor, kChief);
}

// A change that could not be stored was not done, and is in no log.
TEST(PipelineEvents, WhatFailedHasNoEvent) {
  const auto pipeline = OpenInMemory();
  EXPECT_FALSE(pipeline->sessions().Create({kAlice, "no such sensor"}, kChief).ok());
  EXPECT_FALSE(pipeline->sessions().Delete(SessionId("nobody-1"), kChief).ok());
  EXPECT_FALSE(pipeline->decisions().UndoRevision(7, "why", kChief).ok());
  EXPECT_THAT(KindsOf(*pipeline), ElementsAre());
}

TEST(PipelineEvents, AStoreThatFailsIsSaidOnceItWorks) {
  const auto full = std::make_shared<std::atomic<bool>>(false);
  const auto pipeline =
      Pipeline::Open(QuickOptions(), std::make_unique<FullDisk>(storage::MakeMemoryStore(), full))
          .value();
  Submap submap;
  submap.id = {Create(*pipeline), 0};
  submap.keyframes = {{0, 1'000, Pose()}};
  submap.points = {{1, 2, 3, 0, 0}};
  *full = true;
  EXPECT_FALSE(pipeline->sessions().AddSubmap(submap).ok());
  *full = false;
  EXPECT_TRUE(pipeline->sessions().AddSubmap(submap).ok());
  const auto events = EventsOf(*pipeline, {EventKind::kStorageFailed, EventKind::kStorageWorks});
  ASSERT_EQ(events.size(), 2u);
  EXPECT_THAT(events[0].text, HasSubstr("disk full"));
  EXPECT_EQ(events[1].kind, EventKind::kStorageWorks);
}

}  // namespace
}  // namespace isthmus::server
