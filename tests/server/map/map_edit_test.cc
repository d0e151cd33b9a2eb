// Views of the map and what turns one into the next.
#include "server/map/map_edit.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace isthmus::server {
namespace {

SessionId Id(const std::string& robot) { return SessionId(robot + "-1"); }

std::shared_ptr<Submap> MakeSubmap(const std::string& robot, uint32_t index) {
  auto submap = std::make_shared<Submap>();
  submap->id = {Id(robot), index};
  submap->robot = RobotId(robot);
  submap->T_odom_submap = Pose(Eigen::Vector3d(index, 0, 0));
  submap->keyframes = {{index + 1, index + 1, Pose()}};
  submap->points = {{1, 2, 3, 0, 0}};
  return submap;
}

MapEdit WithSubmap(const std::string& robot, uint32_t index) {
  MapEdit edit;
  edit.rests_on = {Id(robot)};
  edit.batch.submaps = {MakeSubmap(robot, index)};
  // Two scans, half a metre apart.
  for (const uint64_t k : {2 * index + 1, 2 * index + 2}) {
    edit.batch.trajectory.push_back(
        {Id(robot), {k, int64_t(k), Pose(Eigen::Vector3d(0.5 * double(k), 0, 0)), index}});
  }
  edit.changes.causes = {"submap"};
  return edit;
}

MapEdit WithMatch(const std::string& a, const std::string& b) {
  MapEdit edit;
  edit.rests_on = {Id(a), Id(b)};
  Match& match = edit.batch.matches.emplace_back();
  match.a = Id(a);
  match.b = Id(b);
  match.state = MatchState::kAccepted;
  match.confidence = 0.9;
  edit.changes.causes = {"match"};
  return edit;
}

// Three robots of `submaps` submaps each.
std::shared_ptr<const MapView> MakeView(uint32_t submaps) {
  auto view = std::make_shared<const MapView>();
  MapEdit sessions;
  for (const char* robot : {"alice", "bob", "carol"}) {
    SessionRecord& record = sessions.batch.sessions.emplace_back();
    record.id = Id(robot);
    record.robot = RobotId(robot);
  }
  view = Apply(*view, sessions);
  for (uint32_t i = 0; i < submaps; ++i) {
    for (const char* robot : {"alice", "bob", "carol"}) view = Apply(*view, WithSubmap(robot, i));
  }
  return view;
}

TEST(MapEdit, LeavesTheOldViewAsItWasAndSharesTheRest) {
  const auto before = MakeView(100);
  const auto after = Apply(*before, WithSubmap("bob", 100));
  EXPECT_EQ(before->Find(Id("bob"))->submaps.size(), 100u);
  EXPECT_EQ(after->Find(Id("bob"))->submaps.size(), 101u);
  EXPECT_EQ(after->serial, before->serial + 1);
  EXPECT_EQ(after->graph_version, before->graph_version + 1);
  EXPECT_FALSE(after->IsPlaced());
  EXPECT_EQ(after->sessions.Get(Id("alice")), before->sessions.Get(Id("alice")));
  EXPECT_EQ(after->Find(Id("bob"))->submaps.Get(7), before->Find(Id("bob"))->submaps.Get(7));
  EXPECT_EQ(after->effective, before->effective);
  EXPECT_EQ(after->revision, before->revision);
}

TEST(MapEdit, ViewsThatNobodyReadsAreGone) {
  auto view = MakeView(3);
  const std::weak_ptr<const MapView> old = view;
  const std::weak_ptr<const SessionView> old_session = view->sessions.Get(Id("bob"));
  const std::weak_ptr<const SessionView> kept = view->sessions.Get(Id("alice"));
  view = Apply(*view, WithSubmap("bob", 3));
  EXPECT_TRUE(old.expired());
  EXPECT_TRUE(old_session.expired());
  EXPECT_FALSE(kept.expired());
}

TEST(MapEdit, FollowsTheWayFromSubmapToSubmap) {
  const auto view = MakeView(3);
  const SessionView& alice = *view->Find(Id("alice"));
  EXPECT_EQ(alice.points, 3u);
  EXPECT_EQ(alice.next_index(), 3u);
  // To the first scan of the next submap; the newest one ends with its own last scan.
  EXPECT_NEAR(*alice.path_length_m.Find(0), 1.0, 1e-12);
  EXPECT_NEAR(*alice.path_length_m.Find(1), 1.0, 1e-12);
  EXPECT_NEAR(*alice.path_length_m.Find(2), 0.5, 1e-12);
  EXPECT_EQ(PlacementInput(*view).sessions.at(0).nodes.at(1).travelled_m, 1.0);
}

// Its cycles are checked from the sessions that have submaps.
TEST(MapEdit, AFirstSubmapAndAMatchMakeEffectiveMatchesAnewOthersDoNot) {
  const auto view = Apply(*MakeView(1), WithMatch("alice", "bob"));
  ASSERT_NE(view->EffectiveMatch({Id("alice"), Id("bob")}), nullptr);
  EXPECT_FALSE(ChangesMatches(WithSubmap("bob", 1), *view));
  EXPECT_TRUE(ChangesMatches(WithMatch("alice", "bob"), *view));
  EXPECT_TRUE(ChangesMatches(WithSubmap("bob", 0), *MakeView(0)));
  MapEdit removal;
  removal.removed_session = Id("bob");
  const auto after = Apply(*view, removal);
  EXPECT_EQ(after->EffectiveMatch({Id("alice"), Id("bob")}), nullptr);
  EXPECT_EQ(after->removals, view->removals + 1);
}

// An edit made ready from an older view takes effect on a newer one with all that came between.
TEST(MapEdit, PreparedBeforeAnotherEditItLosesNothingOfThat) {
  const auto view = MakeView(2);
  const MapEdit match = WithMatch("alice", "bob");
  const PreparedEdit prepared = Prepare(match, *view);
  const auto between = Apply(*view, WithSubmap("carol", 2));
  const auto after = Apply(*between, match, prepared);
  EXPECT_EQ(after->Find(Id("carol"))->submaps.size(), 3u);
  EXPECT_NE(after->EffectiveMatch({Id("alice"), Id("bob")}), nullptr);
}

TEST(MapEdit, IsVoidWithoutTheSessionsItRestsOn) {
  const auto view = MakeView(1);
  EXPECT_FALSE(IsVoid(WithMatch("alice", "bob"), *view));
  MapEdit removal;
  removal.removed_session = Id("bob");
  EXPECT_TRUE(IsVoid(WithMatch("alice", "bob"), *Apply(*view, removal)));
}

TEST(MapEdit, RetiredSubmapsLeaveWithTheLoopsThatHaveNoEdgeLeft) {
  MapEdit loops;
  for (const uint32_t newer : {3u, 4u}) {
    LoopClosure& loop = loops.batch.loops.emplace_back();
    loop.id = newer;
    loop.session = Id("alice");
    loop.submap_b = newer;
    loop.edges = {{0, newer, Pose(), Matrix6d::Identity()}, {1, 4, Pose(), Matrix6d::Identity()}};
  }
  loops.batch.loops.front().edges.pop_back();
  const auto before = Apply(*MakeView(5), loops);
  MapEdit retire;
  retire.batch.retired = {{Id("alice"), 0}, {Id("alice"), 77}, {Id("nobody"), 0}};
  const auto after = Apply(*before, retire);
  EXPECT_EQ(after->retired, 1u);
  EXPECT_FALSE(after->loops.contains(3));
  EXPECT_TRUE(after->loops.contains(4)) << "its other edge is left";
  EXPECT_EQ(after->Find(Id("alice"))->submaps.size(), 4u);
  EXPECT_EQ(after->Find(Id("alice"))->points, 4u);
  EXPECT_EQ(before->loops.size(), 2u);
}

TEST(MapView, SegmentsAreThoseOfTheSessionAndNoOther) {
  MapEdit edit;
  for (const auto& [id, segment, first] :
       {std::tuple("alice-1", 1u, ""), std::tuple("alice-1.2", 2u, "alice-1"),
        std::tuple("alice-1.10", 10u, "alice-1"), std::tuple("alice-10", 1u, ""),
        std::tuple("alice-10.2", 2u, "alice-10")}) {
    SessionRecord& record = edit.batch.sessions.emplace_back();
    record.id = SessionId(id);
    record.robot = RobotId("alice");
    record.segment = segment;
    record.first_segment = SessionId(first);
    record.created_ns = record.opened() == SessionId("alice-10") ? 2 : 1;
  }
  const auto view = Apply(MapView(), edit);
  const auto segments = view->SegmentsOf(SessionId("alice-1"));
  ASSERT_EQ(segments.size(), 3u);
  EXPECT_EQ(segments[1]->record.id, SessionId("alice-1.2"));
  EXPECT_EQ(segments[2]->record.id, SessionId("alice-1.10"));
  EXPECT_EQ(view->Newest(RobotId("alice"))->record.id, SessionId("alice-10.2"));
  EXPECT_TRUE(view->SegmentsOf(SessionId("alice-1.2")).empty());
}

}  // namespace
}  // namespace isthmus::server
