#include "server/threads/crash_journal.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "core/clock.h"
#include "server/pipeline.h"
#include "server/threads/limits.h"
#include "tests/server/pipeline/robots.h"

namespace isthmus::server {
namespace {

class CrashJournalTest : public ::testing::Test {
 protected:
  CrashJournalTest()
      : path_(testing::TempDir() + "/" +
              testing::UnitTest::GetInstance()->current_test_info()->name() + ".journal") {
    std::filesystem::remove(path_);
  }

  // A process that ends while the task is at hand.
  void CrashAt(const std::string& task, const std::string& boot = "b",
               const std::string& version = "1") {
    CrashJournal(path_, boot, version).BeginTask(task);
  }

  const std::string path_;
};

TEST_F(CrashJournalTest, FindsOutWhatWasAtHandTwice) {
  CrashAt("one");
  EXPECT_FALSE(CrashJournal(path_, "b", "1").IsQuarantined("one"));
  CrashAt("two");
  CrashAt("one");
  CrashJournal journal(path_, "b", "1");
  EXPECT_TRUE(journal.IsQuarantined("one"));
  EXPECT_FALSE(journal.IsQuarantined("two"));
  // And remembers.
  journal.BeginTask("three");
  EXPECT_TRUE(CrashJournal(path_, "b", "1").IsQuarantined("one"));
}

TEST_F(CrashJournalTest, AfterAnOrderlyEndItIsTriedOnceMore) {
  for (int i = 0; i < 3; ++i) CrashAt("one");
  EXPECT_TRUE(CrashJournal(path_, "b", "1").IsQuarantined("one"));
  EXPECT_FALSE(CrashJournal(path_, "b", "1").IsQuarantined("one"));
  CrashAt("one");
  EXPECT_TRUE(CrashJournal(path_, "b", "1").IsQuarantined("one"));
}

TEST_F(CrashJournalTest, AfterAWhileItIsTriedOnceMoreAndLaterWithEachFurtherEnd) {
  const absl::Duration little = absl::Seconds(1);
  absl::Duration left_out = kLeftOutAfterCrashes;
  for (int i = 0; i < kMaxCrashes; ++i) CrashAt("one");
  for (int more = 0; more < 4; ++more) {
    CrashJournal journal(path_, "b", "1");
    EXPECT_TRUE(journal.IsQuarantined("one", left_out - little)) << more;
    EXPECT_FALSE(journal.IsQuarantined("one", left_out)) << more;
    journal.BeginTask("one");
    left_out *= 2;
  }
  for (int more = 0; more < 100; ++more) CrashAt("one");
  const CrashJournal journal(path_, "b", "1");
  EXPECT_TRUE(journal.IsQuarantined("one", kLeftOutAtMost - little));
  EXPECT_FALSE(journal.IsQuarantined("one", kLeftOutAtMost));
}

TEST_F(CrashJournalTest, WorkThatEndedIsNotToBlame) {
  for (int i = 0; i < 3; ++i) {
    CrashJournal journal(path_, "b", "1");
    journal.BeginTask("one");
    journal.EndTask();
  }
  EXPECT_FALSE(CrashJournal(path_, "b", "1").IsQuarantined("one"));
}

TEST_F(CrashJournalTest, AServerThatEndsItselfBlamesNobody) {
  CrashAt("two");
  for (int i = 0; i < 3; ++i) {
    CrashAt("one");
    CrashJournal::ClearBlame(path_);
  }
  CrashAt("two");
  const CrashJournal journal(path_, "b", "1");
  EXPECT_FALSE(journal.IsQuarantined("one"));
  EXPECT_TRUE(journal.IsQuarantined("two"));
  CrashJournal::ClearBlame(path_ + ".none");  // No error.
  EXPECT_FALSE(std::filesystem::exists(path_ + ".none"));
}

TEST_F(CrashJournalTest, APowerCutIsNobodysFault) {
  for (const char* boot : {"b1", "b2", "b3"}) CrashAt("one", boot);
  EXPECT_FALSE(CrashJournal(path_, "b4", "1").IsQuarantined("one"));
}

TEST_F(CrashJournalTest, AnotherVersionTriesAgain) {
  for (int i = 0; i < 3; ++i) CrashAt("one");
  EXPECT_FALSE(CrashJournal(path_, "b", "2").IsQuarantined("one"));
}

TEST_F(CrashJournalTest, RubbishInTheFileIsIgnored) {
  std::ofstream(path_) << "crashed x\ncrashed 9\nboot\n" << '\0' << "at_hand";
  EXPECT_FALSE(CrashJournal(path_, "b", "1").IsQuarantined("x"));
}

// A pipeline leaves out the work that two processes ended at, and does the rest.
TEST_F(CrashJournalTest, APipelineLeavesOutWhatEndedItTwice) {
  const auto match_of = [&](std::vector<std::string>* problems) {
    PipelineOptions options = QuickOptions();
    options.crash_journal = path_;
    options.on_problem = [problems](const std::string& problem) { problems->push_back(problem); };
    const Drive drive(2);
    auto pipeline = OpenInMemory(options);
    for (int robot = 0; robot < 2; ++robot) {
      const SessionId session =
          pipeline->sessions().Create({RobotId(robot == 0 ? "a" : "b"), "vlp16"}).value().record.id;
      EXPECT_TRUE(drive.Submit(*pipeline, session, 0, 6, robot).ok());
      EXPECT_TRUE(pipeline->sessions().Finish(session).ok());
    }
    pipeline->WaitUntilIdle();
    return pipeline->reader().GetMatchGraph().matches.size();
  };
  std::vector<std::string> problems;
  EXPECT_EQ(match_of(&problems), 1u);
  EXPECT_TRUE(problems.empty());
  for (int i = 0; i < kMaxCrashes; ++i) CrashJournal(path_).BeginTask("match a-1 b-1");
  EXPECT_EQ(match_of(&problems), 0u);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].find("the match of a-1 and b-1"), std::string::npos) << problems[0];
}

// Someone who kills the server again and again is not to keep maps apart for good.
TEST_F(CrashJournalTest, APipelineComesBackToItAfterAWhile) {
  for (int i = 0; i < kMaxCrashes; ++i) CrashJournal(path_).BeginTask("match a-1 b-1");
  PipelineOptions options = QuickOptions();
  options.crash_journal = path_;
  ManualClock clock(0);
  auto pipeline = Pipeline::Open(options, storage::MakeMemoryStore(), clock).value();
  const Drive drive(2);
  for (int robot = 0; robot < 2; ++robot) {
    const SessionId session =
        pipeline->sessions().Create({RobotId(robot == 0 ? "a" : "b"), "vlp16"}).value().record.id;
    EXPECT_TRUE(drive.Submit(*pipeline, session, 0, 6, robot).ok());
    EXPECT_TRUE(pipeline->sessions().Finish(session).ok());
  }
  pipeline->WaitUntilIdle();
  EXPECT_TRUE(pipeline->reader().GetMatchGraph().matches.empty());
  clock.Advance(absl::ToInt64Nanoseconds(kLeftOutAfterCrashes));
  while (pipeline->reader().GetMatchGraph().matches.empty()) std::this_thread::yield();
  pipeline->WaitUntilIdle();
  EXPECT_EQ(pipeline->reader().GetMatchGraph().matches.size(), 1u);
}

}  // namespace
}  // namespace isthmus::server
