// The drives that a match asks for, where the map has its submaps.
#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>

#include "server/pipeline/view_reader.h"

namespace isthmus::server {
namespace {

constexpr char kAsker[] = "alice-1", kAsked[] = "bob-1";

MapView TwoRobots() {
  MapView view;
  auto revision = std::make_shared<MapRevision>();
  uint32_t component = 0;
  for (const char* id : {kAsker, kAsked}) {
    SessionView session;
    session.record.id = SessionId(id);
    session.record.robot = RobotId(std::string(id, strlen(id) - 2));
    view.sessions.Set(SessionId(id), session);
    Placement& placement = revision->placements.emplace_back();
    placement.session = SessionId(id);
    placement.component = component++;
    placement.submaps = {{3, Pose(Eigen::Vector3d(100, 0, 0))},
                         {4, Pose(Eigen::Vector3d(200, 0, 0))}};
  }
  view.revision = revision;
  return view;
}

Match Asking() {
  Match match;
  match.a = SessionId(kAsker);
  match.b = SessionId(kAsked);
  match.T_a_b = Pose(Eigen::Vector3d(7, 0, 0));
  match.rivals.resize(1);
  match.rivals[0].T_a_b = Pose(Eigen::Vector3d(8, 0, 0));
  AskedDrive& drive = match.asked.emplace_back();
  drive.by_b = true;
  drive.way = {{4, {1, 2, 3}}, {3, {0, 5, 0}}};
  drive.leaves_own = 1;
  drive.length_m = 12;
  drive.confidence = 0.97;
  return match;
}

TEST(AskedDrivesTest, LieWhereTheMapHasTheirSubmaps) {
  const auto drives = ViewReader::Describe(Asking(), TwoRobots()).asked_drives;
  ASSERT_EQ(drives.size(), 1u);
  EXPECT_EQ(drives[0].robot, RobotId("bob"));
  EXPECT_EQ(drives[0].session, SessionId(kAsked));
  ASSERT_EQ(drives[0].way.size(), 2u);
  EXPECT_EQ(drives[0].way[0], Eigen::Vector3d(201, 2, 3));
  EXPECT_EQ(drives[0].way[1], Eigen::Vector3d(100, 5, 0));
  EXPECT_EQ(drives[0].leaves_own, 1u);
  EXPECT_EQ(drives[0].length_m, 12);
  EXPECT_EQ(drives[0].confidence, 0.97);
  EXPECT_EQ(drives[0].T_a_b.translation().x(), 7);
}

TEST(AskedDrivesTest, SayWhichOfTheRivalsTheyAreAbout) {
  Match match = Asking();
  match.asked[0].rival = 1;
  EXPECT_EQ(ViewReader::Describe(match, TwoRobots()).asked_drives.at(0).T_a_b.translation().x(), 8);
  match.asked[0].rival = 2;
  EXPECT_TRUE(ViewReader::Describe(match, TwoRobots()).asked_drives.empty());
}

TEST(AskedDrivesTest, NothingIsAskedWhereItWouldNotHelp) {
  const auto asked = [](const Match& match, const MapView& view) {
    return !ViewReader::Describe(match, view).asked_drives.empty();
  };
  EXPECT_TRUE(asked(Asking(), TwoRobots()));
  Match accepted = Asking();
  accepted.state = MatchState::kAccepted;
  EXPECT_FALSE(asked(accepted, TwoRobots()));
  Match retired = Asking();
  retired.asked[0].way[0].submap = 9;
  EXPECT_FALSE(asked(retired, TwoRobots())) << "Its submap is not in the map.";
  MapView finished = TwoRobots();
  SessionView bob = *finished.Find(SessionId(kAsked));
  bob.record.finished_ns = 1;
  finished.sessions.Set(SessionId(kAsked), bob);
  EXPECT_FALSE(asked(Asking(), finished));
  MapView decided = TwoRobots();
  decided.manual_decisions.Set({SessionId(kAsker), SessionId(kAsked)}, ManualDecision());
  EXPECT_FALSE(asked(Asking(), decided));
}

}  // namespace
}  // namespace isthmus::server
