// A spool whose session is gone, whose files are damaged, or which is full.
#include <future>
#include <thread>

#include "tests/client/library/spooled_stream_fixture.h"

namespace isthmus::client {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class SpoolTroubleTest : public SpooledStreamTest {
 protected:
  // A program that pushed so many scans and died; the server has them, and it knows which of them
  // are durable.
  void DieAfter(int scans) {
    auto stream = Open();
    Push(*stream, scans);
    server_.WaitForScans("alice-1", static_cast<size_t>(scans));
    const uint64_t durable = server_.sessions()["alice-1"].durable;
    while (stream->stats().durable_sequence < durable) std::this_thread::yield();
  }
  void ExpectStop(const std::string& why) {
    const auto stream = client_->ResumeScanStream(options_);
    ASSERT_TRUE(absl::IsFailedPrecondition(stream.status())) << stream.status();
    EXPECT_THAT(std::string(stream.status().message()), HasSubstr(why));
    EXPECT_THAT(std::string(stream.status().message()), HasSubstr("--new-session"));
    EXPECT_THAT(files_.Segments(), Not(IsEmpty()));
  }
  // Push waits for a server that makes nothing durable, and then tells why that is hopeless.
  void ExpectTooSmall(const std::string& why) {
    auto stream = Open();
    auto pushing = std::async(std::launch::async, [&] {
      absl::Status status;
      while ((status = PushOne(*stream)).ok()) continue;
      return status;
    });
    while (pushing.wait_for(std::chrono::milliseconds(1)) != std::future_status::ready) {
      clock_.Advance(10);
    }
    const absl::Status status = pushing.get();
    EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(why));
  }
  // Somebody finishes the session, into which another program streamed so many scans.
  void FinishWithOthers(int scans) {
    server_.Edit([&](auto& sessions) {
      FakeSession& session = sessions["alice-1"];
      for (int i = 0; i < scans; ++i) session.scans.push_back(session.scans.back());
      session.finished = true;
    });
  }
  // The disk keeps so many scans of the spool's one file; 0: not even that.
  void LoseEnd(uint64_t kept) {
    const std::string path = files_.Segments().front();
    if (kept == 0) {
      std::filesystem::remove(path);
      return;
    }
    const std::string bytes = ReadFile(path);
    WriteFile(path, bytes.substr(0, bytes.find(PayloadOf(kept + 1).data)));
  }
  // Goes on as a new session with the scans from the from-th on.
  void ExpectNewSession(uint64_t from) {
    options_.spool.if_session_is_gone = IfSessionIsGone::kNewSession;
    auto stream = client_->ResumeScanStream(options_);
    ASSERT_TRUE(stream.ok()) << stream.status();
    Push(**stream, 3);
    ASSERT_TRUE((*stream)->FinishSession().ok());
    const std::string session = (*stream)->session().value();
    ExpectScans(session, from, pushed_);
    EXPECT_EQ(server_.sessions()[session].request.robot(), "alice");
  }
};

TEST_F(SpoolTroubleTest, NothingToResumeIsSaid) {
  const auto stream = client_->ResumeScanStream(options_);
  ASSERT_TRUE(absl::IsNotFound(stream.status())) << stream.status();
  EXPECT_THAT(std::string(stream.status().message()), HasSubstr("OpenSpool"));
}

TEST_F(SpoolTroubleTest, AFolderMustBeNamed) {
  options_.spool_dir.clear();
  EXPECT_TRUE(absl::IsInvalidArgument(client_->ResumeScanStream(options_).status()));
}

TEST_F(SpoolTroubleTest, ASpoolIsOfOneRobotAndOneProgram) {
  const auto stream = Open();
  EXPECT_TRUE(absl::IsFailedPrecondition(client_->ResumeScanStream(options_).status()));
  auto other = options_;
  other.spool_dir += "2";
  ASSERT_TRUE(client_->OpenSpool({RobotId("bob"), "vlp16"}, other).ok());
  const auto wrong = client_->OpenSpool({RobotId("carol"), "vlp16"}, other);
  ASSERT_TRUE(absl::IsFailedPrecondition(wrong.status())) << wrong.status();
  EXPECT_THAT(std::string(wrong.status().message()), HasSubstr("bob"));
}

TEST_F(SpoolTroubleTest, ASessionThatTheServerDoesNotKnow) {
  server_.durable_every = 100;
  DieAfter(5);
  server_.Edit([](auto& sessions) { sessions.clear(); });
  ExpectStop("does not know it");
  ExpectNewSession(1);
}

// As where the server was started with another folder, and another program was there first.
TEST_F(SpoolTroubleTest, AnotherSessionOfItsName) {
  server_.durable_every = 100;
  DieAfter(5);
  for (const bool finished : {false, true}) {
    SCOPED_TRACE(finished);
    server_.Edit([&](auto& sessions) {
      sessions["alice-1"].created_ns = 2;
      sessions["alice-1"].finished = finished;
    });
    ExpectStop("does not know it");
  }
  ExpectNewSession(1);
  EXPECT_EQ(server_.sessions()["alice-1"].scans.size(), 5u);
}

TEST_F(SpoolTroubleTest, ASessionThatWasFinishedTooEarly) {
  DieAfter(5);
  server_.Edit([](auto& sessions) {
    sessions["alice-1"].scans.resize(3);
    sessions["alice-1"].finished = true;
  });
  ExpectStop("was finished");
  ExpectNewSession(4);
}

TEST_F(SpoolTroubleTest, ASessionThatWasFinishedWithEverythingMakesRoomForTheNext) {
  DieAfter(5);
  server_.Edit([](auto& sessions) { sessions["alice-1"].finished = true; });
  const auto stream = client_->ResumeScanStream(options_);
  ASSERT_TRUE(absl::IsAlreadyExists(stream.status())) << stream.status();
  EXPECT_TRUE(absl::IsNotFound(client_->ResumeScanStream(options_).status()));
  auto next = Open();
  Push(*next, 3);
  ASSERT_TRUE(next->FinishSession().ok());
  ExpectScans("alice-2", 6, 8);
}

// Another program streamed into it, so that what is in the spool may be nowhere.
TEST_F(SpoolTroubleTest, ASessionThatWasFinishedWithMoreThanIsKnownIsNotMovedOnFrom) {
  server_.durable_every = 100;
  DieAfter(5);
  FinishWithOthers(2);
  options_.spool.if_session_is_gone = IfSessionIsGone::kNewSession;
  for (const bool is_replayed : {false, true}) {
    options_.spool.is_replayed = is_replayed;
    const auto stream = client_->ResumeScanStream(options_);
    ASSERT_TRUE(absl::IsFailedPrecondition(stream.status())) << stream.status();
    EXPECT_THAT(std::string(stream.status().message()),
                AllOf(HasSubstr("with 7 scans, and only those up to 5 are from here"),
                      HasSubstr("remove " + options_.spool_dir)));
  }
  EXPECT_THAT(files_.Segments(), Not(IsEmpty()));
  EXPECT_EQ(server_.sessions().size(), 1u);
}

TEST_F(SpoolTroubleTest, ScansTakenWhileTheirSessionWasFinishedWithOthersAreKept) {
  server_.durable_every = 100;
  options_.spool.if_session_is_gone = IfSessionIsGone::kNewSession;
  DieAfter(5);
  for (const bool is_replayed : {true, false}) {
    options_.spool.is_replayed = is_replayed;
    server_.Stop();
    auto stream = Open();
    Push(*stream, 3);
    if (is_replayed) FinishWithOthers(2);
    server_.Start();
    const auto finished = stream->FinishSession();
    EXPECT_EQ(finished.ok(), !is_replayed) << finished.status();
  }
  ExpectScans("alice-2", 6, 11);
}

TEST_F(SpoolTroubleTest, AServerFromAnOlderBackup) {
  options_.spool.max_bytes = 16;  // A file per scan.
  options_.spool.when_full = WhenFull::kWait;
  options_.spool.max_bytes = 1600;
  DieAfter(5);
  server_.Edit([](auto& sessions) {
    sessions["alice-1"].scans.resize(1);
    sessions["alice-1"].durable = 1;
  });
  ExpectStop("older backup");
  // Scans 2 and 3 are gone: the server had said that they are durable.
  const uint64_t oldest = std::stoull(std::filesystem::path(files_.Segments().front()).stem());
  EXPECT_GT(oldest, 2u);
  ExpectNewSession(oldest);
}

TEST_F(SpoolTroubleTest, ASessionThatGoesWhileTheRobotDrivesEndsTheStreamAndKeepsTheScans) {
  server_.durable_every = 100;
  auto stream = Open();
  Push(*stream, 3);
  server_.WaitForScans("alice-1", 3);
  server_.Stop();
  server_.Edit([](auto& sessions) { sessions.clear(); });
  Push(*stream, 1);  // Once the server is back, the stream may end at any moment.
  server_.Start();
  const absl::Status status = stream->Finish();
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  EXPECT_TRUE(absl::IsFailedPrecondition(PushOne(*stream)));
  stream.reset();
  ExpectNewSession(1);
}

// The stream is told of it first, by a server that knows nothing of spools.
TEST_F(SpoolTroubleTest, ASessionThatGoesDuringALinkIsAskedAfterOnce) {
  server_.durable_every = 100;
  for (const bool finished : {false, true}) {
    SCOPED_TRACE(finished);
    options_.spool.if_session_is_gone = IfSessionIsGone::kStop;
    auto stream = Open();
    Push(*stream, 3);
    const std::string id = finished ? "alice-2" : "alice-1";
    server_.WaitForScans(id, 3);
    server_.Edit([&](auto& sessions) {
      if (finished) {
        sessions[id].finished = true;
      } else {
        sessions.erase(id);
      }
    });
    (void)PushOne(*stream);  // The stream may end before.
    const absl::Status status = stream->Finish();
    EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("--new-session"));
    stream.reset();
    options_.spool.if_session_is_gone = IfSessionIsGone::kNewSession;
    ASSERT_TRUE(Open()->FinishSession().ok());
  }
}

TEST_F(SpoolTroubleTest, ADamagedScanUsesUpItsNumber) {
  server_.Stop();
  {
    auto stream = Open();
    Push(*stream, 5);
  }
  std::string bytes = ReadFile(files_.Segments().front());
  bytes[bytes.find(PayloadOf(3).data)] ^= 1;
  WriteFile(files_.Segments().front(), bytes);
  server_.Start();
  auto stream = Open();
  ASSERT_TRUE(stream->Finish().ok());
  EXPECT_EQ(stream->stats().lost, 1u);
  EXPECT_EQ(stream->stats().rejected, 1u);
  ASSERT_EQ(acks().size(), 5u);
  EXPECT_THAT(acks()[2].reason, HasSubstr("damaged in the spool"));
  EXPECT_THAT(events(), HasSubstr("damaged"));
  const auto scans = server_.sessions()["alice-1"].scans;
  ASSERT_EQ(scans.size(), 5u);
  EXPECT_TRUE(scans[2].cloud().data().empty());
  EXPECT_GT(scans[2].end_stamp_ns(), scans[1].end_stamp_ns());
  EXPECT_LT(scans[2].end_stamp_ns(), scans[3].end_stamp_ns());
  for (const uint64_t k : {1, 2, 4, 5}) {
    EXPECT_EQ(scans[k - 1].cloud().data(), PayloadOf(k).data);
  }
}

TEST_F(SpoolTroubleTest, NumbersThatTheServerHasAreNotGivenAgain) {
  server_.durable_every = 100;
  DieAfter(5);
  // The newest scan is lost from the disk, though the server has it.
  const std::string path = files_.Segments().front();
  WriteFile(path, ReadFile(path).substr(0, ReadFile(path).size() - 10));
  auto stream = Open();
  EXPECT_EQ(stream->resumed().last_sequence, 5u);
  EXPECT_EQ(stream->resumed().last_stamp_ns, 4 * kPeriodNs);
  Push(*stream, 2);
  ASSERT_TRUE(stream->Finish().ok());
  ExpectScans("alice-1", 1, 7);
}

TEST_F(SpoolTroubleTest, ReplayedScansThatTheServerHasTakeTheirOwnNumbersAgain) {
  server_.durable_every = 100;
  options_.spool.is_replayed = true;
  DieAfter(9);
  for (const uint64_t kept : {5, 0}) {
    SCOPED_TRACE(kept);
    LoseEnd(kept);
    // A program that pushes nothing, as where it refuses to, leaves no trace.
    ASSERT_TRUE(client_->ResumeScanStream(options_).ok());  // Cuts off half a scan.
    const std::string before = ReadFile(files_.Segments().front());
    ASSERT_TRUE(client_->ResumeScanStream(options_).ok());
    EXPECT_EQ(ReadFile(files_.Segments().front()), before);
    auto stream = Open();
    EXPECT_EQ(stream->resumed().last_sequence, kept);
    ASSERT_TRUE(stream->resumed().server_ahead.has_value());
    const uint64_t known = server_.sessions()["alice-1"].scans.size();
    EXPECT_EQ(*stream->resumed().server_ahead, static_cast<int64_t>(known - kept));
    pushed_ = kept;
    Push(*stream, 12 - static_cast<int>(kept));
    server_.WaitForScans("alice-1", 12);
    EXPECT_EQ(stream->stats().pushed, 12 - known);
  }
  // They are kept until they are durable.
  server_.Crash();
  server_.Start();
  ASSERT_TRUE(Open()->FinishSession().ok());
  ExpectScans("alice-1", 1, 12);
}

TEST_F(SpoolTroubleTest, OfAReplayNothingIsSentBeforeItsSourceIsKnownToBeTheSame) {
  server_.Stop();
  options_.spool.is_replayed = true;
  Push(*Open(), 5);
  server_.Start();
  auto stream = client_->ResumeScanStream(options_);
  ASSERT_TRUE(stream.ok()) << stream.status();
  options_.spool_dir += "2";
  const auto other = client_->OpenSpool({RobotId("bob"), "vlp16"}, options_);
  ASSERT_TRUE(other.ok()) << other.status();
  Push(**other, 20);
  ASSERT_TRUE((*other)->FinishSession().ok());
  EXPECT_EQ(server_.sessions().size(), 1u);
  ASSERT_TRUE((*stream)->FinishSession().ok());
  ExpectScans((*stream)->session().value(), 1, 5);
}

TEST_F(SpoolTroubleTest, AReplayThatIsShorterThanWhatTheServerHasIsRefused) {
  server_.durable_every = 100;
  options_.spool.is_replayed = true;
  DieAfter(9);
  LoseEnd(5);
  auto stream = Open();
  pushed_ = 5;
  Push(*stream, 2);
  EXPECT_TRUE(absl::IsFailedPrecondition(stream->FinishSession().status()));
  EXPECT_FALSE(server_.sessions()["alice-1"].finished);
}

// The robot cannot know then that its numbers were given to others.
TEST_F(SpoolTroubleTest, NumbersGivenAgainOutOfReachOfTheServerAreRefusedEachTime) {
  server_.durable_every = 100;
  DieAfter(9);
  LoseEnd(5);
  server_.Stop();
  {
    auto stream = Open();
    Push(*stream, 3);
  }
  auto stream = Open();
  Push(*stream, 1);
  server_.Start();
  EXPECT_TRUE(absl::IsFailedPrecondition(stream->Finish()));
  stream.reset();
  for (int time = 0; time < 2; ++time) ExpectStop("only those up to 5 are from here");
  ExpectNewSession(10);
  ExpectScans("alice-1", 1, 9);
}

TEST_F(SpoolTroubleTest, AReplayOutOfReachOfTheServerGoesOnOnceItCanBeCompared) {
  server_.durable_every = 100;
  options_.spool.is_replayed = true;
  options_.spool.if_session_is_gone = IfSessionIsGone::kNewSession;
  DieAfter(9);
  LoseEnd(5);
  server_.Stop();
  pushed_ = 5;
  auto stream = Open();
  Push(*stream, 1);
  server_.Start();
  const absl::Status refused = stream->Finish();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("Try again"));
  stream = nullptr;
  stream = Open();
  EXPECT_EQ(stream->resumed().last_sequence, 6u);
  EXPECT_EQ(stream->resumed().server_ahead, 3);
  Push(*stream, 6);
  ASSERT_TRUE(stream->FinishSession().ok());
  ExpectScans("alice-1", 1, 12);
}

TEST_F(SpoolTroubleTest, AFullSpoolRefusesIfToldSo) {
  options_.spool.max_bytes = 4000;
  options_.spool.when_full = WhenFull::kRefuse;
  server_.Stop();
  auto stream = Open();
  absl::Status status;
  while ((status = PushOne(*stream)).ok()) ASSERT_LT(pushed_, 1000u);
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("raise max_bytes"));
  EXPECT_LE(stream->stats().spool_bytes, 4000u);
  server_.Start();
  server_.WaitForScans("alice-1", pushed_);
  while (!PushOne(*stream).ok()) continue;  // Until the acknowledgement has made room.
  ASSERT_TRUE(stream->FinishSession().ok());
  ExpectScans("alice-1", 1, pushed_);
}

TEST_F(SpoolTroubleTest, AFullSpoolMakesPushWait) {
  options_.spool.max_bytes = 4000;
  server_.Stop();
  auto stream = Open();
  auto pushing = std::async(std::launch::async, [&] { Push(*stream, 200); });
  server_.Start();
  pushing.wait();
  ASSERT_TRUE(stream->FinishSession().ok());
  ExpectScans("alice-1", 1, 200);
}

#ifdef ISTHMUS_TEST_WITHOUT_NETWORK
TEST_F(SpoolTroubleTest, AFullDiskMakesPushWait) {
  // With and without room for the head of another file behind the last scan.
  for (const uint64_t room : {4000, 4030, 4060, 4090}) {
    SCOPED_TRACE(room);
    const SmallDisk disk(options_.spool_dir, room);
    client_->disk = &disk.calls();
    server_.Stop();
    const uint64_t first = pushed_ + 1;
    auto stream = Open();
    auto pushing = std::async(std::launch::async, [&] { Push(*stream, 200); });
    while (events().find("waits for room") == std::string::npos) std::this_thread::yield();
    server_.Start();
    pushing.wait();
    const auto session = stream->FinishSession();
    ASSERT_TRUE(session.ok()) << session.status();
    ExpectScans(session->record.id.value(), first, pushed_);
    MutexLock lock(&mutex_);
    events_.clear();
  }
}

TEST_F(SpoolTroubleTest, ADiskTooSmallForTheServerIsToldInsteadOfWaitingForEver) {
  server_.durable_every = 1000;
  const SmallDisk disk(options_.spool_dir, 4000);
  client_->disk = &disk.calls();
  ExpectTooSmall("200 more");
}
#endif

TEST_F(SpoolTroubleTest, ASpoolTooSmallForTheServerIsToldInsteadOfWaitingForEver) {
  server_.durable_every = 1000;
  options_.spool.max_bytes = 4000;
  ExpectTooSmall("did not make durable");
}

TEST_F(SpoolTroubleTest, AFullSpoolGivesUpTheOldestIfToldSo) {
  options_.spool.max_bytes = 4000;
  options_.spool.when_full = WhenFull::kDropOldest;
  server_.Stop();
  auto stream = Open();
  Push(*stream, 100);
  EXPECT_LE(stream->stats().spool_bytes, 4000u);
  server_.Start();
  ASSERT_TRUE(stream->FinishSession().ok());
  const auto scans = server_.sessions()["alice-1"].scans;
  ASSERT_EQ(scans.size(), 100u) << "their numbers are used up";
  const uint64_t lost = stream->stats().lost;
  EXPECT_GT(lost, 0u);
  EXPECT_LT(lost, 90u);
  for (uint64_t k = 1; k <= 100; ++k) {
    EXPECT_EQ(scans[k - 1].cloud().data(), k <= lost ? "" : PayloadOf(k).data) << k;
  }
}

}  // namespace
}  // namespace isthmus::client
