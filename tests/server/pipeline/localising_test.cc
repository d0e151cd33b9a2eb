// Robots that are found in the map: their names, and the answers to them while there is no map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/clock.h"
#include "core/concurrency/executor.h"
#include "server/localisation/localisation_maps.h"
#include "server/localisation/localising_robots.h"

namespace isthmus::localisation {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;

TEST(LocalisingRobots, AreListedFromTheirBeginningToTheirEnd) {
  ManualClock clock(100 * kSecond_ns);
  LocalisingRobots robots(&clock);
  auto bob = robots.Enter(RobotId("bob"));
  clock.Advance(5 * kSecond_ns);
  const auto alice = robots.Enter(RobotId("alice"));
  bob->NoteScan();
  clock.Advance(2 * kSecond_ns);
  std::vector<RobotPlace> list = robots.List();
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].robot, RobotId("alice"));
  EXPECT_EQ(list[0].localising->scans, 0u);
  EXPECT_EQ(list[0].localising->received_ns, 0);
  EXPECT_EQ(list[1].localising->since_ns, 100 * kSecond_ns);
  EXPECT_EQ(list[1].localising->received_ns, 105 * kSecond_ns);
  EXPECT_DOUBLE_EQ(list[1].lag_ms, 2000);

  LocalisedScan located;
  located.state = LocalisationState::kLocated;
  located.component = 3;
  located.T_map_sensor = Pose(Eigen::Vector3d(1, 2, 3));
  bob->NotePlace(located, 7);
  const RobotPlace known = robots.List()[1];
  EXPECT_EQ(known.component, 3u);
  EXPECT_EQ(known.T_map_sensor.translation().y(), 2);
  EXPECT_EQ(known.stamp_ns, 7);
  EXPECT_EQ(known.lag_ms, 0);
  EXPECT_EQ(known.localising->state, LocalisationState::kLocated);

  // A scan that is of no use says nothing of the place; one without a place takes it away.
  bob->NoteScan();
  bob->NotePlace({.rejected = "no points"}, 8);
  EXPECT_EQ(robots.List()[1].component, 3u);
  EXPECT_EQ(robots.List()[1].localising->rejected, 1u);
  bob->NoteScan();
  bob->NotePlace({.state = LocalisationState::kSearching}, 9);
  EXPECT_FALSE(robots.List()[1].component.has_value());
  EXPECT_EQ(robots.List()[1].localising->scans, 3u);

  bob = nullptr;
  list = robots.List();
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].robot, RobotId("alice"));
}

// A server that was just started, and one that has just got a robot's first submap, are asked
// again.
TEST(LocalisationMaps, WhileWhatCameIsBeingPlacedRobotsAskAgain) {
  server::MapView view;
  view.revision = std::make_shared<MapRevision>();
  server::SessionView session;
  session.record.id = SessionId("alice-1");
  session.record.robot = RobotId("alice");
  view.sessions.Set(session.record.id, std::make_shared<server::SessionView>(session));
  view.graph_version = view.placed_version + 1;
  Executor executor{Executor::Options{.threads = 1, .name = "test"}};
  LocalisationMaps maps([&] { return std::make_shared<server::MapView>(view); },
                        [](const SubmapId&) { return nullptr; }, &Clock::System(), &executor);
  EXPECT_TRUE(absl::IsUnavailable(maps.Get(RobotId()).status()));
  EXPECT_TRUE(absl::IsUnavailable(maps.Get(RobotId("alice")).status()));
  EXPECT_TRUE(absl::IsNotFound(maps.Get(RobotId("bob")).status()));
  view.placed_version = view.graph_version;
  EXPECT_TRUE(absl::IsFailedPrecondition(maps.Get(RobotId()).status()));
  EXPECT_TRUE(absl::IsFailedPrecondition(maps.Get(RobotId("alice")).status()));
}

}  // namespace
}  // namespace isthmus::localisation
