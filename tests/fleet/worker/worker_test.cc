// isthmus-worker as a program: it takes the matching off a server's hands, and may die of it.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "fleet/postgresql/limits.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/worker_store.h"
#include "server/jobs/job.h"
#include "server/jobs/limits.h"
#include "server/matching/index/limits.h"
#include "server/threads/limits.h"
#include "storage/memory_store.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/server/main/child_process.h"
#include "tests/server/pipeline/many_sessions.h"
#include "tests/server/pipeline/robots.h"
#include "tests/storage/records.h"

namespace isthmus::server {
namespace {

class WorkerTest : public ::testing::Test {
 protected:
  WorkerTest()
      : database_(storage::PostgresServer::Shared()),
        site_(database_.NewSite()),
        folder_(::testing::TempDir() + "worker_" + std::to_string(getpid())) {
    std::filesystem::create_directories(folder_);
  }
  ~WorkerTest() override { std::filesystem::remove_all(folder_); }

  static matching::LoopOptions QuickLoops() {
    matching::LoopOptions options;
    options.min_path_length_m = 15;  // A minute's drive has one.
    return options;
  }
  // `before` is in the store already; none of it before `next` has to be searched for loops.
  void OpenServer(const storage::WriteBatch& before = {}, const SubmapId& next = {}) {
    PipelineOptions options = QuickOptions();
    options.submap = {};
    options.loops = loops_;
    options.on_problem = [this](const std::string& problem) {
      const bool may_tell = !may_tell_.empty() && problem.find(may_tell_) != std::string::npos;
      if (!may_tell) ADD_FAILURE() << problem;
    };
    auto store = storage::OpenPostgresStore(database_.url(), site_);
    ASSERT_TRUE(store.ok()) << store.status();
    ASSERT_TRUE((*store)->Write(before).ok());
    if (next.index > 0) {
      ASSERT_TRUE((*store)->Write({.matching_progress = {{next.session, next.index}}}).ok());
    }
    queue_ = (*store)->jobs();
    server_ = std::move(Pipeline::Open(options, *std::move(store))).value();
  }
  // A server looks for workers when it starts, and then every few seconds: a worker that is to be
  // seen in time is there before it.
  void MakeSite() { ASSERT_TRUE(storage::OpenPostgresStore(database_.url(), site_).ok()); }
  std::unique_ptr<storage::JobTaker> HireTaker() {
    return std::move(storage::JobTaker::Open(database_.url(), site_, "taker")).value();
  }
  // The next job, for which it waits.
  static storage::TakenJob TakeOne(storage::JobTaker& taker) {
    while (true) {
      if (auto job = taker.Take().value()) return *job;
      EXPECT_TRUE(taker.KeepAlive(std::nullopt).value());
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  std::unique_ptr<ChildProcess> Hire() { return Hire(database_.url()); }
  std::unique_ptr<ChildProcess> Hire(const std::string& url) {
    const std::string log = folder_ + "/log" + std::to_string(hired_++);
    return std::make_unique<ChildProcess>(
        ISTHMUS_WORKER, std::vector<std::string>{"--store", url, "--site", site_}, log);
  }
  std::string Jobs() const { return "\"" + storage::SchemaOfSite(site_) + "\".jobs"; }
  static void AwaitWords(const ChildProcess& worker, const std::string& words) {
    while (worker.Errors().find(words) == std::string::npos) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  // Maps of a minute each can be joined; with shorter ones the result does not matter. The taker,
  // if any, gives signs of life meanwhile.
  void DriveTwo(int scans = 120, storage::JobTaker* taker = nullptr) {
    const Drive drive(2, 4);
    for (int robot = 0; robot < 2; ++robot) {
      const SessionId session = Create(*server_, robot == 0 ? kAlice : kBob);
      for (int i = 0; i < scans; ++i) {
        ASSERT_TRUE(server_->sessions().SubmitScan(session, drive.Upload(i, robot)).ok());
        if (taker != nullptr) {
          ASSERT_TRUE(taker->KeepAlive(std::nullopt).value());
        }
      }
      ASSERT_TRUE(server_->sessions().Finish(session).ok());
    }
  }

  // Drives two, and has the job of their match killed worker after worker.
  void SetMatchAside(storage::JobTaker& taker) {
    DriveTwo(120, &taker);
    for (int i = 0; i < storage::kMaxAttempts; ++i) {
      (void)TakeOne(taker);
      ASSERT_TRUE(database_.Execute("UPDATE " + Jobs() + " SET lease_until = now()"));
    }
    EXPECT_EQ(taker.Take().value(), std::nullopt);
    server_->WaitUntilIdle();
    EXPECT_EQ(server_->GetLoad().matching.jobs_set_aside, 1u);
    EXPECT_TRUE(server_->reader().GetMatchGraph().matches.empty());
  }
  void AwaitNothingSetAside() {
    while (server_->GetLoad().matching.jobs_set_aside > 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  // A session up to the first submap that closes a loop, as the first of more sessions than any
  // server searches by itself; and that submap.
  static std::pair<storage::WriteBatch, SubmapId> AliceWhoComesBackAndOthers() {
    auto memory = storage::MakeMemoryStore();
    const storage::MapStore* store = memory.get();
    PipelineOptions options = QuickOptions();
    options.submap = {};
    options.loops = QuickLoops();
    const auto pipeline = Pipeline::Open(options, std::move(memory)).value();
    const SessionId session = Create(*pipeline, kAlice);
    const Drive drive(1, 4);
    EXPECT_TRUE(drive.Submit(*pipeline, session, 0, 600).ok());
    EXPECT_TRUE(pipeline->sessions().Finish(session).ok());
    pipeline->WaitUntilIdle();
    SubmapId closing{session, ~uint32_t{0}};
    const std::vector<LoopClosure> loops = store->ListLoops().value();
    for (const LoopClosure& loop : loops) {
      closing.index = std::min(closing.index, loop.submap_b);
    }
    storage::WriteBatch batch = ManySessions(kLoopsAtHome + 4);
    batch.sessions.push_back(store->GetSession(session).value());
    for (uint32_t i = 0; i <= closing.index; ++i) {
      const auto submap = store->GetSubmap({session, i});
      if (submap.ok()) batch.submaps.push_back(*submap);
    }
    return {batch, closing};
  }

  // The matches of two robots that drive at once, as each submap comes, less times.
  static std::string MatchesOfTwo(uint32_t world, Pipeline& server) {
    const Drive drive(2, world);
    const SessionId sessions[] = {Create(server, kAlice), Create(server, kBob)};
    std::string bytes;
    for (int i = 0; i < 400; ++i) {
      for (int robot = 0; robot < 2; ++robot) {
        EXPECT_TRUE(server.sessions().SubmitScan(sessions[robot], drive.Upload(i, robot)).ok());
        server.WaitUntilIdle();
      }
      if (i % 100 < 99) continue;
      for (MatchEdge& edge : server.reader().GetMatchGraph().matches) {
        edge.match.computed_ns = 0;
        for (StageTime& stage : edge.match.stages) stage.ms = 0;
        bytes += EncodeResult(PairResult{edge.match, {}});
      }
    }
    return bytes;
  }

  // All that there is of the two.
  void ExpectMatched() {
    server_->WaitUntilIdle();
    const std::vector<MatchEdge> matches = server_->reader().GetMatchGraph().matches;
    ASSERT_EQ(matches.size(), 1u);
    EXPECT_NE(matches[0].match.reason, MatchReason::kNone);
    EXPECT_EQ(matches[0].match.submaps_a + matches[0].match.submaps_b,
              server_->reader().ListSubmaps(std::nullopt)->size());
  }

  storage::PostgresServer& database_;
  const std::string site_, folder_;
  storage::JobQueue* queue_ = nullptr;
  std::unique_ptr<Pipeline> server_;
  int hired_ = 0;
  matching::LoopOptions loops_ = QuickLoops();
  std::string may_tell_;  // A problem that is no failure of the test.
};

TEST_F(WorkerTest, MatchesWhatTheServerWouldMatch) {
  MakeSite();
  const auto worker = Hire();
  AwaitWords(*worker, "at work");
  OpenServer();
  DriveTwo(600);
  ExpectMatched();
  EXPECT_EQ(server_->GetMapInfo().components.size(), 1u);
  worker->Signal(SIGTERM);
  EXPECT_EQ(worker->Wait(), 0) << worker->Errors();
  EXPECT_NE(worker->Errors().find("the match of alice-1 and bob-1: "), std::string::npos)
      << worker->Errors();
  EXPECT_TRUE(queue_->ListAll()->empty());
  EXPECT_TRUE(queue_->ListEnded()->empty());
}

class WorkerWorldTest : public WorkerTest, public ::testing::WithParamInterface<uint32_t> {};

TEST_P(WorkerWorldTest, MapsAreTheSameToTheLastBitWithAndWithoutWorkers) {
  MakeSite();
  const auto worker = Hire();
  AwaitWords(*worker, "at work");
  loops_.enabled = false;  // They may be found before a match or after it, with workers or without.
  OpenServer();
  const std::string by_workers = MatchesOfTwo(GetParam(), *server_);
  worker->Signal(SIGTERM);  // The result is taken before the worker has said so.
  EXPECT_EQ(worker->Wait(), 0);
  EXPECT_NE(worker->Errors().find("the match of alice-1 and bob-1: "), std::string::npos);
  EXPECT_NE(by_workers.find("extend"), std::string::npos) << "they go on from what was found";
  server_.reset();
  PipelineOptions options = QuickOptions();
  options.submap = {};
  options.loops = loops_;
  const auto alone = Pipeline::Open(options, storage::MakeMemoryStore()).value();
  EXPECT_EQ(by_workers, MatchesOfTwo(GetParam(), *alone));
}

INSTANTIATE_TEST_SUITE_P(Worlds, WorkerWorldTest, ::testing::Values(4, 10, 11));

TEST_F(WorkerTest, WhatAWorkerLeavesUndoneIsDoneByAnother) {
  MakeSite();
  const auto taker = HireTaker();  // Takes a job, and is never heard of again.
  OpenServer();
  DriveTwo(120, taker.get());
  (void)TakeOne(*taker);
  ASSERT_TRUE(database_.Execute("UPDATE " + Jobs() + " SET lease_until = now()"));
  const auto worker = Hire();
  ExpectMatched();
  worker->Signal(SIGTERM);  // The result is taken before the worker has said so.
  EXPECT_EQ(worker->Wait(), 0);
  EXPECT_NE(worker->Errors().find("the match of "), std::string::npos) << worker->Errors();
}

TEST_F(WorkerTest, WithoutWorkersTheServerDoesItsJobsItself) {
  MakeSite();
  auto taker = HireTaker();
  OpenServer();
  DriveTwo(120, taker.get());
  (void)TakeOne(*taker);
  taker.reset();  // Its last word: it is not there any more.
  ExpectMatched();
  EXPECT_TRUE(queue_->ListAll()->empty());
}

TEST_F(WorkerTest, WhatVanishesFromTheBoardIsPostedAgain) {
  MakeSite();
  const auto taker = HireTaker();
  OpenServer();
  DriveTwo(120, taker.get());
  (void)TakeOne(*taker);
  ASSERT_TRUE(database_.Execute("DELETE FROM " + Jobs()));
  const auto worker = Hire();  // The taker lives as well, as far as the server can see.
  ExpectMatched();
  worker->Signal(SIGTERM);  // The result is taken before the worker has said so.
  EXPECT_EQ(worker->Wait(), 0);
  EXPECT_NE(worker->Errors().find("the match of "), std::string::npos) << worker->Errors();
}

TEST_F(WorkerTest, WhatWasSetAsideIsShownAndTriedAgainOnceItsRowIsGone) {
  MakeSite();
  auto taker = HireTaker();
  may_tell_ = "ended while";
  OpenServer();
  SetMatchAside(*taker);
  // Without workers the server does not do it either, neither this one nor the next.
  taker.reset();
  server_.reset();
  OpenServer();
  server_->WaitUntilIdle();
  EXPECT_EQ(server_->GetLoad().matching.jobs_set_aside, 1u);
  EXPECT_TRUE(server_->reader().GetMatchGraph().matches.empty());
  const auto worker = Hire();
  AwaitWords(*worker, "at work");
  ASSERT_TRUE(database_.Execute("DELETE FROM " + Jobs()));
  AwaitNothingSetAside();
  ExpectMatched();
}

TEST_F(WorkerTest, WhatWasSetAsideOfADeletedSessionIsForgotten) {
  MakeSite();
  auto taker = HireTaker();
  may_tell_ = "ended while";
  OpenServer();
  for (const bool by_the_next_server : {false, true}) {
    SetMatchAside(*taker);
    if (by_the_next_server) {
      server_.reset();
      OpenServer();
    }
    for (const SessionStatus& session : server_->sessions().List()) {
      ASSERT_TRUE(server_->sessions().Delete(session.record.id).ok());
    }
    AwaitNothingSetAside();
    EXPECT_TRUE(queue_->ListAll()->empty());
  }
}

// After a start a deleted session's name may be given again.
TEST_F(WorkerTest, AMatchOfADeletedSessionIsNotTakenForTheNextOfItsName) {
  MakeSite();
  auto taker = HireTaker();
  OpenServer();
  DriveTwo(120, taker.get());
  const storage::TakenJob job = TakeOne(*taker);
  const SessionId deleted = server_->sessions().List().back().record.id;
  server_.reset();
  // No event says that there was one, as if that had been forgotten: its name is given again.
  ASSERT_TRUE(
      storage::OpenPostgresStore(database_.url(), site_).value()->DeleteSession(deleted).ok());
  OpenServer();
  EXPECT_EQ(Create(*server_, kBob), deleted);
  EXPECT_FALSE(taker->Finish(job, "a match").value());
  EXPECT_TRUE(queue_->ListAll()->empty());
}

TEST_F(WorkerTest, AServerThatCannotCountWorkersDoesItItself) {
  MakeSite();
  const auto taker = HireTaker();
  may_tell_ = "workers cannot be counted";
  OpenServer();
  DriveTwo(120, taker.get());
  (void)TakeOne(*taker);
  ASSERT_TRUE(database_.Execute("ALTER TABLE \"" + storage::SchemaOfSite(site_) +
                                "\".workers RENAME COLUMN seen TO seen_no_more"));
  ExpectMatched();
}

TEST_F(WorkerTest, AResultOfAnotherPairIsNone) {
  MakeSite();
  auto taker = HireTaker();
  may_tell_ = "another pair's";
  OpenServer();
  DriveTwo(120, taker.get());
  const storage::TakenJob job = TakeOne(*taker);
  const PairResult forged{storage::MakeMatch("alice-1", "carol-1"), {}};
  EXPECT_TRUE(taker->Finish(job, EncodeResult(forged)).value());
  (void)TakeOne(*taker);  // Posted again.
  taker.reset();
  ExpectMatched();
}

TEST_F(WorkerTest, OneThatCouldNotReadTheMapLeavesItToTheServer) {
  MakeSite();
  const std::string role = "poor_" + site_, schema = "\"" + storage::SchemaOfSite(site_) + "\"";
  ASSERT_TRUE(database_.Execute(
      "CREATE ROLE \"" + role + "\" LOGIN; GRANT USAGE ON SCHEMA " + schema + " TO \"" + role +
      "\"; GRANT ALL ON ALL TABLES IN SCHEMA " + schema + " TO \"" + role + "\"; REVOKE ALL ON " +
      schema + ".submaps FROM \"" + role + "\""));
  const auto worker = Hire("postgresql:///postgres?user=" + role + "&host=" + database_.folder());
  AwaitWords(*worker, "waits: its role in the database needs SELECT on submaps");
  OpenServer();
  DriveTwo();
  ExpectMatched();
  ASSERT_TRUE(database_.Execute("GRANT SELECT ON " + schema + ".submaps TO \"" + role + "\""));
  AwaitWords(*worker, "at work");
  ASSERT_TRUE(database_.Execute("REVOKE DELETE ON " + schema + ".workers FROM \"" + role + "\""));
  AwaitWords(*worker, "waits: its role in the database needs DELETE on workers");
}

// As on a full disk: PostgreSQL reads, and cannot write.
TEST_F(WorkerTest, AResultThatCannotBeWrittenIsKeptUntilItCan) {
  MakeSite();
  const std::string schema = "\"" + storage::SchemaOfSite(site_) + "\"";
  ASSERT_TRUE(database_.Execute(
      "SET search_path TO " + schema +
      "; CREATE TABLE attempts (attempt BIGINT); "
      "CREATE FUNCTION full_disk() RETURNS trigger AS $$ BEGIN RAISE EXCEPTION 'disk is full' "
      "USING "
      "ERRCODE = '53100'; END $$ LANGUAGE plpgsql; CREATE FUNCTION note() RETURNS trigger AS $$ "
      "BEGIN INSERT INTO " +
      schema +
      ".attempts VALUES (NEW.attempt); RETURN NEW; END $$ LANGUAGE "
      "plpgsql; CREATE TRIGGER a_note BEFORE UPDATE ON jobs FOR EACH ROW WHEN (NEW.state = 'done') "
      "EXECUTE FUNCTION note(); CREATE TRIGGER full_disk BEFORE UPDATE ON jobs FOR EACH ROW WHEN "
      "(NEW.state = 'done') EXECUTE FUNCTION full_disk()"));
  const auto worker = Hire();
  AwaitWords(*worker, "at work");
  OpenServer();
  DriveTwo();
  AwaitWords(*worker, "waits: ");
  ASSERT_TRUE(database_.Execute("DROP TRIGGER full_disk ON " + Jobs()));
  ExpectMatched();
  // It was taken once.
  EXPECT_TRUE(database_.Execute("INSERT INTO " + schema +
                                ".attempts SELECT 1 / (count(*) = 0)::int "
                                "FROM " +
                                schema + ".attempts WHERE attempt <> 1"));
}

TEST_F(WorkerTest, AServerTakesWhatWasDoneForTheOneBefore) {
  MakeSite();
  const auto taker = HireTaker();
  OpenServer();
  DriveTwo(120, taker.get());
  const storage::TakenJob job = TakeOne(*taker);
  server_.reset();
  ASSERT_TRUE(taker->GiveBack(job).value());
  const auto worker = Hire();
  AwaitWords(*worker, "the match of ");
  OpenServer();
  ExpectMatched();
}

// The choice is the server's, by what the worker has compared.
TEST_F(WorkerTest, OfManySessionsItComparesThePlans) {
  constexpr size_t kCount = matching::kSearchAllSessions + 2;
  MakeSite();
  const auto worker = Hire();
  AwaitWords(*worker, "at work");
  OpenServer(ManySessions(kCount));
  server_->WaitUntilIdle();
  worker->Signal(SIGTERM);
  EXPECT_EQ(worker->Wait(), 0);
  std::map<SessionId, size_t> partners;
  for (const MatchEdge& edge : server_->reader().GetMatchGraph().matches) {
    ++partners[edge.match.a];
    ++partners[edge.match.b];
  }
  for (size_t i = 0; i < kCount; ++i) {
    EXPECT_GE(partners[NameOfMany(i)], matching::kSearchPartners) << i;
    const std::string task = "the partners of " + NameOfMany(i).value() + ": ";
    EXPECT_NE(worker->Errors().find(task), std::string::npos) << worker->Errors();
  }
}

// The last submap of each session is asked at the start: more than the server keeps for itself.
TEST_F(WorkerTest, OfManySubmapsItSearchesForLoops) {
  const auto [batch, closing] = AliceWhoComesBackAndOthers();
  MakeSite();
  const auto worker = Hire();
  AwaitWords(*worker, "at work");
  OpenServer(batch, closing);
  server_->WaitUntilIdle();
  worker->Signal(SIGTERM);  // The result is taken before the worker has said so.
  EXPECT_EQ(worker->Wait(), 0);
  EXPECT_NE(worker->Errors().find("the loops of " + ToString(closing) + ": "), std::string::npos)
      << worker->Errors();
  const ListAt<Loop> loops = server_->reader().ListLoops(std::nullopt).value();
  ASSERT_EQ(loops.size(), 1u) << worker->Errors();
  EXPECT_EQ(loops[0].loop.submap_b, closing.index);
  EXPECT_EQ(server_->GetLoad().matching.submaps, 0u);
  EXPECT_EQ(server_->GetLoad().matching.jobs, 0u);
}

// Workers may be at pairs for half a minute each.
TEST_F(WorkerTest, LoopsThatNoWorkerComesToAreTakenBack) {
  MakeSite();
  const auto taker = HireTaker();  // It takes none.
  const auto [batch, closing] = AliceWhoComesBackAndOthers();
  OpenServer(batch, closing);
  while (server_->reader().ListLoops(std::nullopt)->empty()) {
    ASSERT_TRUE(taker->KeepAlive(std::nullopt).value());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(server_->reader().ListLoops(std::nullopt)->at(0).loop.submap_b, closing.index);
}

TEST_F(WorkerTest, WaitsForItsSiteAndEndsWhenTold) {
  const auto worker = Hire();
  AwaitWords(*worker, "waits");
  OpenServer();
  AwaitWords(*worker, "at work");
  EXPECT_EQ(queue_->CountWorkers().value().able, 1);
  worker->Signal(SIGINT);
  EXPECT_EQ(worker->Wait(), 0) << worker->Errors();
  EXPECT_EQ(queue_->CountWorkers().value().able, 0);
}

TEST(WorkerUsage, SaysWhatIsWrong) {
  ChildProcess none(ISTHMUS_WORKER, {}, ::testing::TempDir() + "worker_usage");
  EXPECT_EQ(none.Wait(), 2);
  ChildProcess site(ISTHMUS_WORKER, {"--store", "postgresql://host/base", "--site", "../x"},
                    ::testing::TempDir() + "worker_site");
  EXPECT_EQ(site.Wait(), 2);
  EXPECT_NE(site.Errors().find("cannot name a site"), std::string::npos) << site.Errors();
  ChildProcess empty(ISTHMUS_WORKER, {"--store", "postgresql://host/base", "--log-file", ""},
                     ::testing::TempDir() + "worker_empty");
  EXPECT_EQ(empty.Wait(), 2);
  EXPECT_NE(empty.Errors().find("--log-file has no value"), std::string::npos) << empty.Errors();
  ChildProcess secret(ISTHMUS_WORKER, {"--store", "postgresql://me:secret@host/base"},
                      ::testing::TempDir() + "worker_secret");
  EXPECT_EQ(secret.Wait(), 2);
  EXPECT_NE(secret.Errors().find("leave the password out"), std::string::npos) << secret.Errors();
}

}  // namespace
}  // namespace isthmus::server
