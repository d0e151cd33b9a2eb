// A robot's scans through dead links, crashes of its server and of its own program.
#include <absl/strings/str_split.h>

#include <algorithm>
#include <future>
#include <thread>

#include "tests/client/library/spooled_stream_fixture.h"

namespace isthmus::client {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Le;
using testing::SizeIs;

constexpr double kScanBytes = 83;  // As it lies in the spool.

TEST_F(SpooledStreamTest, ADriveWithoutTroubleLeavesNothingInTheSpool) {
  auto stream = Open();
  Push(*stream, 30);
  const auto session = stream->FinishSession();
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->record.state, SessionState::kFinished);
  ExpectScans("alice-1", 1, 30);
  ASSERT_THAT(acks(), SizeIs(30));
  for (uint64_t k = 1; k <= 30; ++k) {
    EXPECT_EQ(acks()[k - 1].sequence, k);
    EXPECT_EQ(acks()[k - 1].end_stamp_ns, static_cast<int64_t>(k) * kPeriodNs);
  }
  EXPECT_THAT(files_.Segments(), IsEmpty());
  EXPECT_EQ(stream->stats().processed, 30u);
  EXPECT_EQ(stream->stats().backlog, 0u);
}

TEST_F(SpooledStreamTest, AProgramThatDiesAgainAndAgainLosesAndDoublesNothing) {
  server_.durable_every = 7;
  server_.break_every = 11;
  for (int life = 0; life < 12; ++life) {
    auto stream = Open();
    EXPECT_EQ(stream->resumed().last_sequence, pushed_);
    EXPECT_EQ(stream->resumed().last_stamp_ns, static_cast<int64_t>(pushed_) * kPeriodNs);
    Push(*stream, 1 + life);
    if (life % 3 == 0) server_.WaitForScans("alice-1", pushed_ / 2);
    if (life % 4 == 1) {
      server_.Crash();
      server_.Start();
    }
    // Its end comes without Finish.
  }
  auto stream = client_->ResumeScanStream(options_);
  ASSERT_TRUE(stream.ok()) << stream.status();
  ASSERT_TRUE((*stream)->FinishSession().ok());
  ExpectScans("alice-1", 1, pushed_);
  EXPECT_THAT(server_.sessions(), SizeIs(1));
}

// As of a proxy in front of a server that hangs.
TEST_F(SpooledStreamTest, StreamsThatEndAtADeadlineAreLostLinks) {
  server_.break_every = 3;
  server_.break_code = absl::StatusCode::kDeadlineExceeded;
  auto stream = Open();
  Push(*stream, 10);
  ASSERT_TRUE(stream->FinishSession().ok());
  ExpectScans("alice-1", 1, 10);
}

TEST_F(SpooledStreamTest, BeginsAndGoesOnOutOfReachOfTheServer) {
  server_.Stop();
  {
    auto stream = Open();
    Push(*stream, 5);
    EXPECT_EQ(stream->stats().backlog, 5u);
    EXPECT_TRUE(stream->session().empty());
  }
  auto stream = Open();
  Push(*stream, 5);
  server_.Start();
  ASSERT_TRUE(stream->Finish().ok());
  ExpectScans("alice-1", 1, 10);
}

TEST_F(SpooledStreamTest, NeverGivesUpAndWaitsLongerEachTimeUpToALimit) {
  server_.Stop();
  std::promise<void> patient;
  on_wait_ = [&] {
    if (waits_.size() == 40) patient.set_value();
  };
  auto stream = Open();
  Push(*stream, 3);
  patient.get_future().wait();
  server_.Start();
  ASSERT_TRUE(stream->Finish().ok());
  ExpectScans("alice-1", 1, 3);
  MutexLock lock(&mutex_);
  EXPECT_THAT(waits_, Each(Le(1.0)));
  EXPECT_LT(waits_.front(), 0.11);
  EXPECT_GT(waits_[39], 0.6);
}

TEST_F(SpooledStreamTest, ASessionWhoseCreationWasNotAnsweredIsNotOpenedTwice) {
  server_.lost_creations = 1;
  {
    auto stream = Open();
    Push(*stream, 2);
  }
  auto stream = Open();
  Push(*stream, 2);
  ASSERT_TRUE(stream->Finish().ok());
  EXPECT_GE(server_.creations, 2);
  EXPECT_THAT(server_.sessions(), SizeIs(1));
  ExpectScans("alice-1", 1, 4);
}

TEST_F(SpooledStreamTest, WhatTheServerForgotInACrashIsSentAgain) {
  server_.durable_every = 10;
  auto stream = Open();
  Push(*stream, 25);
  server_.WaitForScans("alice-1", 25);
  server_.Crash();
  server_.Start();
  Push(*stream, 5);
  ASSERT_TRUE(stream->FinishSession().ok());
  ExpectScans("alice-1", 1, 30);
}

TEST_F(SpooledStreamTest, ASessionIsNotFinishedWithoutWhatACrashTook) {
  server_.durable_every = 10;
  server_.crashes_at_finish = 3;
  auto stream = Open();
  Push(*stream, 25);
  ASSERT_TRUE(stream->FinishSession().ok());
  ExpectScans("alice-1", 1, 25);
}

TEST_F(SpooledStreamTest, FinishFirstAndTheSessionLater) {
  server_.durable_every = 10;
  auto stream = Open();
  Push(*stream, 25);
  ASSERT_TRUE(stream->Finish().ok());
  EXPECT_FALSE(server_.sessions()["alice-1"].finished);
  EXPECT_TRUE(absl::IsFailedPrecondition(PushOne(*stream)));
  ASSERT_TRUE(stream->FinishSession().ok());
  EXPECT_TRUE(server_.sessions()["alice-1"].finished);
  EXPECT_THAT(files_.Segments(), IsEmpty());
}

TEST_F(SpooledStreamTest, ALinkOnWhichNothingMovesIsOpenedAnew) {
  server_.mute_streams = 2;
  auto stream = Open();
  Push(*stream, 3);
  for (int dead = 1; dead <= 2; ++dead) {
    // The clock may run on so far that a link is given up before all was sent.
    server_.WaitFor([&](auto&) { return server_.muted >= 3 * dead || server_.streams > dead; });
    while (server_.streams <= dead) {
      clock_.Advance(1);
      std::this_thread::yield();
    }
  }
  ASSERT_TRUE(stream->Finish().ok());
  ExpectScans("alice-1", 1, 3);
  EXPECT_GE(server_.streams, 3);
  EXPECT_THAT(events(), HasSubstr("no progress"));
}

TEST_F(SpooledStreamTest, AnOutageIsToldOnceAndSoIsItsEnd) {
  server_.Stop();
  auto stream = Open();
  Push(*stream, 3);
  while (stream->stats().reconnects < 10) std::this_thread::yield();
  server_.Start();
  ASSERT_TRUE(stream->Finish().ok());
  const std::vector<std::string> lines = absl::StrSplit(events(), '\n', absl::SkipEmpty());
  EXPECT_EQ(std::ranges::count_if(
                lines, [](auto& line) { return line.starts_with("interrupted, trying again: "); }),
            1)
      << events();
  EXPECT_EQ(
      std::ranges::count_if(lines, [](auto& line) { return line.starts_with("goes on after "); }),
      1)
      << events();
}

// As of a program that died while its connection still had scans under way.
TEST_F(SpooledStreamTest, ScansThatComeInBetweenTwoLinksAreTakenUp) {
  {
    auto stream = Open();
    Push(*stream, 5);
    server_.WaitForScans("alice-1", 5);
  }
  std::vector<v1::ScanMessage> late;
  server_.Edit([&](auto& sessions) {
    auto& scans = sessions["alice-1"].scans;
    late.assign(scans.begin() + 3, scans.end());
    scans.resize(3);
  });
  options_.window = 1;
  server_.mute_streams = 1;
  auto stream = Open();
  server_.WaitFor([&](auto&) { return server_.muted >= 1; });  // It has sent one of the two.
  server_.Edit([&](auto& sessions) {
    auto& scans = sessions["alice-1"].scans;
    scans.insert(scans.end(), late.begin(), late.end());
  });
  const int before = server_.streams;
  while (server_.streams == before) {
    clock_.Advance(1);
    std::this_thread::yield();
  }
  Push(*stream, 2);
  ASSERT_TRUE(stream->Finish().ok());
  ExpectScans("alice-1", 1, 7);
}

TEST_F(SpooledStreamTest, GoesOnBehindWhatOthersSentMeanwhile) {
  auto stream = Open();
  server_.WaitFor([&](auto&) { return server_.streams >= 1; });
  server_.Edit([](auto& sessions) {
    sessions["alice-1"].scans.resize(3);
    sessions["alice-1"].durable = 3;
  });
  // A link that is only being opened may outlive a stop.
  for (int looks = 0; stream->stats().durable_sequence < 3; ++looks) {
    if (looks % 10'000 == 0) {
      server_.Stop();
      server_.Start();
    }
    std::this_thread::yield();
  }
  Push(*stream, 2);
  ASSERT_TRUE(stream->Finish().ok());
  ASSERT_EQ(server_.sessions()["alice-1"].scans.size(), 5u);
  EXPECT_EQ(server_.sessions()["alice-1"].scans[3].cloud().data(), PayloadOf(1).data);
}

class MemoryStreamTest : public SpooledStreamTest {
 protected:
  MemoryStreamTest() {
    options_.spool_dir.clear();
    server_.Edit([](auto& sessions) { sessions["alice-1"].request.set_robot("alice"); });
  }
  std::unique_ptr<ScanStream> OpenInMemory() {
    auto stream = client_->OpenScanStream(SessionId("alice-1"), options_);
    EXPECT_TRUE(stream.ok()) << stream.status();
    return *std::move(stream);
  }
};

TEST_F(MemoryStreamTest, LostLinksLoseAndDoubleNothing) {
  server_.durable_every = 7;
  server_.break_every = 11;
  options_.window = 4;
  auto stream = OpenInMemory();
  Push(*stream, 100);
  const auto session = stream->FinishSession();
  ASSERT_TRUE(session.ok()) << session.status();
  ExpectScans("alice-1", 1, 100);
  ASSERT_THAT(acks(), SizeIs(100));
  for (uint64_t k = 1; k <= 100; ++k) {
    EXPECT_EQ(acks()[k - 1].sequence, k);
    EXPECT_EQ(acks()[k - 1].end_stamp_ns, static_cast<int64_t>(k) * kPeriodNs);
  }
  EXPECT_EQ(stream->stats().backlog, 0u);
}

TEST_F(MemoryStreamTest, PushWaitsForTheWindowAndCanBeGivenUp) {
  server_.mute_streams = 1000;
  options_.window = 3;
  auto stream = OpenInMemory();
  Push(*stream, 3);
  auto waits = std::async(std::launch::async, [&] { return PushOne(*stream); });
  EXPECT_EQ(waits.wait_for(std::chrono::milliseconds(20)), std::future_status::timeout);
  EXPECT_EQ(stream->stats().backlog, 3u);
  stream->GiveUp();
  EXPECT_TRUE(absl::IsCancelled(waits.get()));
  EXPECT_TRUE(absl::IsCancelled(stream->Finish()));
  EXPECT_TRUE(absl::IsCancelled(PushOne(*stream)));
}

TEST_F(SpooledStreamTest, BackfillKeepsToItsRate) {
  options_.spool.backfill_bytes_per_s = 10 * kScanBytes;
  server_.Stop();
  {
    auto stream = Open();
    Push(*stream, 45);
    EXPECT_NEAR(static_cast<double>(stream->stats().spool_bytes) / 45,
                kScanBytes + io::kRecordHeaderBytes, 4);
  }
  auto stream = Open();
  server_.Start();
  // The first second's scans come at once, and one that goes into debt.
  server_.WaitForScans("alice-1", 10);
  for (size_t second = 1; second <= 3; ++second) {
    EXPECT_LE(static_cast<size_t>(server_.got_scans), 10 * second + 1);
    clock_.Advance(1);
    server_.WaitForScans("alice-1", 10 * second + 10);
  }
  clock_.Advance(10);
  ASSERT_TRUE(stream->Finish().ok());
  ExpectScans("alice-1", 1, 45);
}

TEST_F(SpooledStreamTest, LiveScansGoAheadOfAnOldBacklogInASessionOfTheirOwn) {
  options_.spool.prefer_live_after_s = 1;
  options_.spool.backfill_bytes_per_s = 10 * kScanBytes;
  auto stream = Open();
  Push(*stream, 5);
  server_.WaitForScans("alice-1", 5);
  server_.Stop();
  Push(*stream, 40);  // Four seconds.
  clock_.Advance(4);
  server_.Start();
  server_.WaitFor([](auto& sessions) { return sessions.size() == 2; });
  Push(*stream, 5);
  server_.WaitForScans("alice-2", 5);
  EXPECT_LT(server_.sessions()["alice-1"].scans.size(), 45u) << "the backlog is still under way";
  // The rate is counted from the first old scan on: one second's worth goes at once. Were the clock
  // moved before that, that second would have passed unused, and the last scans never come.
  server_.WaitForScans("alice-1", 15);
  for (const size_t scans : {25, 35, 45}) {
    clock_.Advance(1);
    server_.WaitForScans("alice-1", scans);
  }
  ASSERT_TRUE(stream->FinishSession().ok());
  ExpectScans("alice-1", 1, 45);
  ExpectScans("alice-2", 46, 50);
  EXPECT_EQ(stream->session(), SessionId("alice-2"));
  EXPECT_EQ(stream->stats().pushed, 50u);
  EXPECT_THAT(files_.Segments(), IsEmpty());
}

TEST_F(SpooledStreamTest, LiveScansGoAheadThoughOneWasBeingPushedWhenTheLinkCameBack) {
  options_.spool.prefer_live_after_s = 1;
  options_.spool.backfill_bytes_per_s = 10 * kScanBytes;
  options_.spool.when_full = WhenFull::kWait;
  options_.spool.max_bytes = 4000;
  server_.Stop();
  auto stream = Open();
  const double room = kScanBytes + io::kRecordHeaderBytes + 8;
  while (static_cast<double>(stream->stats().spool_bytes) + room < 4000) Push(*stream, 1);
  clock_.Advance(4);
  std::promise<void> pushes;
  std::thread waits_for_room([&] {
    pushes.set_value();
    Push(*stream, 2);
  });
  pushes.get_future().wait();
  server_.Start();
  waits_for_room.join();
  ASSERT_NE(events().find("new scans go into another"), std::string::npos);
  server_.WaitForScans("alice-2", 1);
  EXPECT_LT(server_.sessions()["alice-1"].scans.size(), pushed_ - 2) << "it is still under way";
}

TEST_F(SpooledStreamTest, BothSessionsAreTakenUpAgain) {
  options_.spool.prefer_live_after_s = 1;
  options_.spool.backfill_bytes_per_s = 1;  // The backlog stays.
  server_.Stop();
  {
    auto stream = Open();
    Push(*stream, 40);
    server_.Start();
    server_.WaitFor([](auto& sessions) { return sessions.size() == 2; });
    Push(*stream, 5);
    server_.WaitForScans("alice-2", 5);
  }
  options_.spool.backfill_bytes_per_s = 0;
  auto stream = client_->ResumeScanStream(options_);
  ASSERT_TRUE(stream.ok()) << stream.status();
  EXPECT_EQ((*stream)->session(), SessionId("alice-2"));
  Push(**stream, 5);
  ASSERT_TRUE((*stream)->FinishSession().ok());
  ExpectScans("alice-1", 1, 40);
  ExpectScans("alice-2", 41, 50);
  EXPECT_TRUE(server_.sessions()["alice-1"].finished);
}

}  // namespace
}  // namespace isthmus::client
