#include "client/console/top_frame.h"

#include <absl/strings/str_join.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "client/console/localising_text.h"
#include "client/console/server_figures.h"

namespace isthmus::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr size_t kWide = std::numeric_limits<size_t>::max();
constexpr int64_t kSecond_ns = 1'000'000'000;

SessionLoad Alice() {
  SessionLoad alice;
  alice.session = SessionId("alice-1");
  alice.robot = RobotId("alice");
  alice.tracking = Tracking::kLost;
  alice.lost_since_ns = 1'700'000'041'300'000'000;
  alice.waiting_scans = 3;
  alice.waiting_bytes = 1'200'000;
  alice.received_sequence = 120;
  alice.acknowledged_sequence = 118;
  alice.durable_sequence = 59;
  alice.oldest_unacknowledged_ns = 100 * kSecond_ns;
  alice.oldest_undurable_ns = 94 * kSecond_ns;
  alice.map_bytes = 5'000'000;
  alice.scan_bytes = 1'000'000;
  return alice;
}

ServerStatus Status() {
  ServerStatus status;
  status.version = "1.2.3";
  status.site = "yard";
  status.started_ns = 7;
  status.uptime_s = 100'000;
  status.process = {500, 512'000'000, 31, 40, 4096};
  status.calls = {2, 1, 0, 0, 1};
  status.load.now_ns = 100 * kSecond_ns + 300'000'000;
  status.load.sessions = {Alice()};
  status.load.revision = 812;
  status.load.submaps = 214;
  status.load.matching = {false, 2, 3};
  status.load.composition_ms = 12.34;
  status.load.disk = {1'000'000'000, 0, 200'000'000, 0, 300'000'000'000, 500'000'000'000};
  return status;
}

TopView View() {
  TopView view{"box:50051", Status(), Status(), {}};
  view.before->uptime_s -= 2;
  view.before->process.cpu_s -= 3;
  view.before->load.sessions[0].received_sequence -= 20;
  return view;
}

std::string Text(const TopView& view, size_t columns = kWide) {
  return absl::StrJoin(TopLines(view, columns), "\n");
}

TEST(TopFrame, SaysWhatWorkersDo) {
  TopView view = View();
  view.status->load.matching = {true, 0, 0, 4, 0, 1};
  EXPECT_THAT(Text(view), HasSubstr("matching idle, 4 workers, 1 jobs set aside   composition"));
}

TEST(TopFrame, SaysHowServerAndRobotsAreGettingOn) {
  const std::string text = Text(View());
  EXPECT_THAT(text, HasSubstr("isthmus 1.2.3 at box:50051, site yard   up 1 d 03:46:40"));
  EXPECT_THAT(text, HasSubstr("revision 812, 214 submaps"));
  EXPECT_THAT(text, HasSubstr("cpu 150 %   memory 512.0 MB   threads 31   files 40 of 4096"));
  EXPECT_THAT(text, HasSubstr("disk 1.2 GB used, 300.0 GB free"));
  EXPECT_THAT(text, HasSubstr("matching 2 submaps, 3 pairs   composition 12.3 ms"));
  EXPECT_THAT(
      text,
      HasSubstr(
          "\nSESSION  STATE  SCANS/S  QUEUE      ACK LAG   DURABLE LAG  STORED  LOST SINCE"
          "\nalice-1  LOST   10.0     3, 1.2 MB  2, 0.3 s  61, 6.3 s    6.0 MB  1700000041.3"));
}

TEST(TopFrame, ShowsRobotsThatAreLocalised) {
  TopView view = View();
  RobotPlace bob{.robot = RobotId("bob"), .lag_ms = 340};
  bob.localising = {
      LocalisationState::kLocated, Tracking::kOk, 60 * kSecond_ns, 100 * kSecond_ns, 400, 2};
  view.status->load.sessions.clear();
  view.status->load.localising = {bob};
  bob.localising->scans = 380;
  view.before->load.localising = {bob};
  const std::string text = Text(view);
  EXPECT_THAT(text, HasSubstr("\nbob, localised  located  10.0     -      0.3 s    "));
  EXPECT_THAT(text, Not(HasSubstr("no open sessions")));
}

TEST(TopFrame, WithoutAnEarlierStatusThereAreNoRates) {
  TopView view = View();
  view.before.reset();
  EXPECT_THAT(Text(view), HasSubstr("cpu -"));
  EXPECT_THAT(Text(view), HasSubstr("LOST   -  "));
  view = View();
  view.before->started_ns = 6;  // The server was started again since.
  EXPECT_THAT(Text(view), HasSubstr("cpu -"));
}

TEST(TopFrame, ANarrowTerminalLosesWhatMattersLeast) {
  for (size_t columns = 1; columns < 120; ++columns) {
    for (const std::string& line : TopLines(View(), columns)) EXPECT_LE(line.size(), columns);
  }
  const std::string narrow = Text(View(), 60);
  EXPECT_THAT(narrow, HasSubstr("\nmatching 2 submaps, 3 pairs   composition"))
      << "the header has more lines";
  EXPECT_THAT(narrow, HasSubstr("DURABLE LAG"));
  EXPECT_THAT(narrow, Not(HasSubstr("LOST SINCE")));
  EXPECT_THAT(Text(View(), 20), HasSubstr("SESSION  STATE"));
  EXPECT_THAT(Text(View(), 20), Not(HasSubstr("SCANS/S")));
}

TEST(TopFrame, NothingFromTheNetworkReachesTheTerminalAsItCame) {
  TopView view = View();
  view.status->version = "\x1b]0;owned\x07";
  view.status->site = "a\nb";
  view.status->load.sessions[0].session = SessionId("\x1b[2J\xc2\x9b");
  view.status->degraded = {{"isthmus.v1.MapService", "bad\r\x7f"}};
  view.problem = "gone\x1b[31m";
  for (const std::string& line : TopLines(view, kWide)) {
    for (const char c : line) EXPECT_TRUE(c >= ' ' && c <= '~') << line;
  }
  EXPECT_THAT(Text(view), HasSubstr("\\x1b[2J\\xc2\\x9b"));
}

TEST(TopFrame, SaysWhatIsWrong) {
  TopView view = View();
  view.problem = "box:50051 does not answer";
  view.status->degraded = {{"isthmus.v1.SessionService", "the disk is nearly full"}};
  EXPECT_THAT(Text(view), HasSubstr("CONNECTION LOST, trying again: box:50051 does not answer"));
  EXPECT_THAT(Text(view), HasSubstr("DEGRADED isthmus.v1.SessionService: the disk is nearly full"));
  view = TopView{"box:50051", {}, {}, "it hung up"};
  EXPECT_THAT(Text(view), HasSubstr("it hung up"));
  view.status = Status();
  view.status->load.sessions.clear();
  EXPECT_THAT(Text(view), HasSubstr("no open sessions"));
}

TEST(ServerFigures, LagsAreInScansAndSecondsWhereThoseAreKnown) {
  const int64_t now_ns = 101 * kSecond_ns;
  EXPECT_EQ(ToString(AckLag(Alice(), now_ns)), "2 scans, 1.0 s");
  EXPECT_EQ(ToString(DurableLag(Alice(), now_ns)), "61 scans, 7.0 s");
  SessionLoad resumed = Alice();
  resumed.acknowledged_sequence = 120;
  resumed.durable_sequence = 119;
  resumed.oldest_unacknowledged_ns = resumed.oldest_undurable_ns = 0;
  EXPECT_EQ(ToString(AckLag(resumed, now_ns)), "none");
  EXPECT_EQ(ToString(DurableLag(resumed, now_ns)), "1 scan");
  EXPECT_EQ(DurableLag(Alice(), 0).seconds, 0) << "the clock was set back";
}

TEST(ServerFigures, UpTimesAreDaysAndTimes) {
  EXPECT_EQ(UpTimeText(12.9), "00:00:12");
  EXPECT_EQ(UpTimeText(3 * 86'400 + 4 * 3600 + 5 * 60 + 6), "3 d 04:05:06");
  EXPECT_EQ(UpTimeText(-1), "00:00:00");
}

TEST(LocalisingText, SaysWhereARobotIsAndHowWellThatIsKnown) {
  RobotPlace place;
  place.localising.emplace();
  place.localising->since_ns = 1000 * kSecond_ns;
  EXPECT_EQ(NameOf(place), "(unnamed)");
  EXPECT_EQ(LocalisingText(place, 1063 * kSecond_ns), "localised since 00:01:03: no scans yet");
  place.robot = RobotId("bob");
  place.localising->scans = 600;
  place.localising->received_ns = 1060 * kSecond_ns;
  EXPECT_EQ(NameOf(place), "bob");
  EXPECT_EQ(LocalisingText(place, 1063 * kSecond_ns),
            "localised since 00:01:03: searching; 600 scans, 10.0/s, the last 3.0 s ago");
  place.localising->state = LocalisationState::kLocated;
  place.component = 2;
  place.T_map_sensor = Pose(Eigen::Vector3d(1, -2.5, 0.25));
  EXPECT_EQ(LocalisingText(place, 1063 * kSecond_ns),
            "localised since 00:01:03: located at 1.00, -2.50, 0.25 of map 2; 600 scans, "
            "10.0/s, the last 3.0 s ago");
}

}  // namespace
}  // namespace isthmus::cli
