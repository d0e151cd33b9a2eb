// Jobs go to one worker each, come back once, and outlive the workers that had them.
#include "storage/job_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/concurrency/mutex.h"
#include "fleet/postgresql/limits.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/worker_store.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using ::testing::HasSubstr;

class JobQueueTest : public ::testing::Test {
 protected:
  JobQueueTest()
      : server_(PostgresServer::Shared()),
        site_(server_.NewSite()),
        store_(std::move(OpenPostgresStore(server_.url(), site_)).value()),
        queue_(store_->jobs()) {}

  std::unique_ptr<JobTaker> Hire(const std::string& name) {
    return std::move(JobTaker::Open(server_.url(), site_, name)).value();
  }
  // As if the workers had given no sign for longer than that.
  void LetLeasesEnd() { Execute("UPDATE jobs SET lease_until = now() - interval '1 second'"); }
  void Execute(const std::string& sql) {
    ASSERT_TRUE(server_.Execute("SET search_path TO \"" + SchemaOfSite(site_) + "\"; " + sql));
  }

  PostgresServer& server_;
  const std::string site_;
  std::unique_ptr<MapStore> store_;
  JobQueue* const queue_;
};

TEST_F(JobQueueTest, AJobIsDoneAndItsResultTakenOff) {
  const std::string payload("\0\xff payload", 10);
  ASSERT_TRUE(queue_->Post({"pair", payload}).ok());
  EXPECT_EQ(queue_->ListAll()->at(0).payload, payload);
  const auto worker = Hire("worker");
  const TakenJob job = worker->Take()->value();
  EXPECT_EQ(job.key, "pair");
  EXPECT_EQ(job.payload, payload);
  EXPECT_EQ(*worker->Take(), std::nullopt);
  EXPECT_TRUE(queue_->ListEnded()->empty());
  EXPECT_TRUE(queue_->ListAll()->at(0).is_open);
  EXPECT_TRUE(*worker->Finish(job, payload));
  EXPECT_FALSE(queue_->ListAll()->at(0).is_open);
  const std::vector<EndedJob> ended = queue_->ListEnded().value();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].key, "pair");
  EXPECT_EQ(ended[0].result, payload);
  EXPECT_EQ(ended[0].problem, "");
  ASSERT_TRUE(queue_->Remove(ended).ok());
  EXPECT_TRUE(queue_->ListEnded()->empty());
}

TEST_F(JobQueueTest, WhatCannotBeDoneSaysWhy) {
  ASSERT_TRUE(queue_->Post({"pair", "payload"}).ok());
  const auto worker = Hire("worker");
  EXPECT_TRUE(*worker->Fail(worker->Take()->value(), "no memory"));
  EXPECT_EQ(queue_->ListEnded()->at(0).problem, "no memory");
}

TEST_F(JobQueueTest, NoTwoWorkersGetTheSameJob) {
  constexpr int kJobs = 40, kWorkers = 4;
  for (int i = 0; i < kJobs; ++i) {
    ASSERT_TRUE(queue_->Post({"job " + std::to_string(i), ""}).ok());
  }
  Mutex mutex;
  std::map<std::string, int> taken;
  std::vector<std::thread> threads;
  threads.reserve(kWorkers);
  for (int i = 0; i < kWorkers; ++i) {
    threads.emplace_back([&, i] {
      const auto worker = Hire("worker " + std::to_string(i));
      while (true) {
        const auto job = worker->Take().value();
        if (!job) return;
        EXPECT_TRUE(worker->Finish(*job, "").value());
        MutexLock lock(&mutex);
        ++taken[job->key];
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(taken.size(), static_cast<size_t>(kJobs));
  for (const auto& [key, times] : taken) EXPECT_EQ(times, 1) << key;
}

TEST_F(JobQueueTest, TheJobOfAWorkerThatIsOverdueIsAnothers) {
  ASSERT_TRUE(queue_->Post({"pair", ""}).ok());
  const auto slow = Hire("slow"), other = Hire("other");
  const TakenJob job = slow->Take()->value();
  EXPECT_TRUE(*slow->KeepAlive(job));
  EXPECT_EQ(*other->Take(), std::nullopt);
  LetLeasesEnd();
  const TakenJob again = other->Take()->value();
  EXPECT_EQ(again.id, job.id);
  // The slow worker is too late, whatever it brings.
  EXPECT_FALSE(*slow->KeepAlive(job));
  EXPECT_FALSE(*slow->Finish(job, "late"));
  EXPECT_FALSE(*slow->Fail(job, "late"));
  EXPECT_FALSE(*slow->GiveBack(job));
  EXPECT_TRUE(*other->Finish(again, "result"));
  EXPECT_FALSE(*slow->Finish(job, "later"));
  EXPECT_EQ(queue_->ListEnded()->at(0).result, "result");
}

TEST_F(JobQueueTest, AJobThatWorkersDieOfIsSetAsideAndNotPostedAgain) {
  ASSERT_TRUE(queue_->Post({"poison", "payload"}).ok());
  const auto worker = Hire("worker");
  for (int i = 0; i < kMaxAttempts; ++i) {
    ASSERT_TRUE(worker->Take()->has_value()) << i;
    LetLeasesEnd();
  }
  EXPECT_EQ(*worker->Take(), std::nullopt);
  const std::vector<EndedJob> ended = queue_->ListEnded().value();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_TRUE(ended[0].is_set_aside);
  EXPECT_THAT(ended[0].problem, HasSubstr("worker after worker ended"));
  const QueuedJob poison = queue_->ListAll()->at(0);
  EXPECT_EQ(poison.key, "poison");
  EXPECT_EQ(poison.payload, "payload");
  EXPECT_TRUE(poison.is_set_aside && !poison.is_open);
  EXPECT_EQ(queue_->ListKeys()->count("poison"), 1u);
  // Told once, and remembered.
  ASSERT_TRUE(queue_->Remove(ended).ok());
  EXPECT_TRUE(queue_->ListEnded()->empty());
  const absl::Status status = queue_->Post({"poison", ""});
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  ASSERT_TRUE(queue_->Post({"wholesome", ""}).ok());
  EXPECT_EQ(worker->Take()->value().key, "wholesome");
  // As the reason says.
  Execute("DELETE FROM jobs WHERE key = 'poison'");
  EXPECT_TRUE(queue_->Post({"poison", ""}).ok());
}

TEST_F(JobQueueTest, AJobThatNobodyCanCountOnIsSetAsideAndOthersAreDone) {
  const auto worker = Hire("worker");
  for (const std::string attempt : {"9223372036854775807", "-9223372036854775808", "1000"}) {
    for (const std::string state : {"state = 'waiting'", "state = 'taken', lease_until = now()"}) {
      ASSERT_TRUE(queue_->Post({"forged " + attempt + state, ""}).ok());
      Execute("UPDATE jobs SET " + state + ", attempt = " + attempt + " WHERE state = 'waiting'");
      ASSERT_TRUE(queue_->Post({"pair", ""}).ok());
      const auto job = worker->Take();
      ASSERT_TRUE(job.ok()) << job.status() << ": " << attempt << ", " << state;
      ASSERT_TRUE(job->has_value()) << attempt << ", " << state;
      EXPECT_EQ((*job)->key, "pair");
      EXPECT_TRUE(*worker->Finish(**job, ""));
    }
  }
}

TEST_F(JobQueueTest, WhatAWorkerGivesBackCountsAsNeverTaken) {
  ASSERT_TRUE(queue_->Post({"pair", ""}).ok());
  const auto worker = Hire("worker");
  for (int i = 0; i < 2 * kMaxAttempts; ++i) {
    EXPECT_TRUE(*worker->GiveBack(worker->Take()->value()));
  }
  EXPECT_TRUE(worker->Take()->has_value());
}

TEST_F(JobQueueTest, ANewerJobOfTheSameKeyTakesTheOldOnesPlace) {
  ASSERT_TRUE(queue_->Post({"pair", "old"}).ok());
  const auto worker = Hire("worker");
  const TakenJob old = worker->Take()->value();
  ASSERT_TRUE(queue_->Post({"pair", "new"}).ok());
  EXPECT_FALSE(*worker->KeepAlive(old));
  EXPECT_FALSE(*worker->Finish(old, "of the old one"));
  EXPECT_EQ(worker->Take()->value().payload, "new");
}

TEST_F(JobQueueTest, WhatIsWithdrawnIsNobodysAndWhatIsDoneStays) {
  const auto worker = Hire("worker");
  ASSERT_TRUE(queue_->Post({"done", ""}).ok());
  EXPECT_TRUE(*worker->Finish(worker->Take()->value(), "result"));
  ASSERT_TRUE(queue_->Post({"taken", ""}).ok());
  const TakenJob taken = worker->Take()->value();
  ASSERT_TRUE(queue_->Post({"waits", ""}).ok());
  ASSERT_TRUE(queue_->Withdraw().ok());
  EXPECT_FALSE(*worker->KeepAlive(taken));
  EXPECT_EQ(*worker->Take(), std::nullopt);
  ASSERT_EQ(queue_->ListEnded()->size(), 1u);
  EXPECT_EQ(queue_->ListEnded()->at(0).key, "done");
}

// The last worker may be gone before it was set aside: the server would be next.
TEST_F(JobQueueTest, WhatSeveralWorkersEndedWithIsNotWithdrawn) {
  ASSERT_TRUE(queue_->Post({"poison", ""}).ok());
  const auto worker = Hire("worker");
  for (int i = 0; i <= kMaxWithdrawnAttempts; ++i) {
    ASSERT_TRUE(worker->Take()->has_value()) << i;
    LetLeasesEnd();
  }
  ASSERT_TRUE(queue_->Post({"wholesome", ""}).ok());
  ASSERT_TRUE(queue_->Withdraw().ok());
  EXPECT_EQ(*queue_->ListKeys(), std::set<std::string>{"poison"});
  EXPECT_TRUE(queue_->ListAll()->at(0).is_set_aside);
  EXPECT_TRUE(queue_->ListEnded()->at(0).is_set_aside);
}

TEST_F(JobQueueTest, AJobIsDroppedHoweverFarItIsAndTakenBackWhereNobodyHasBegun) {
  for (const std::string key : {"taken", "other", "waits"}) {
    ASSERT_TRUE(queue_->Post({key, ""}).ok());
  }
  const auto worker = Hire("worker");
  const TakenJob taken = worker->Take()->value();
  EXPECT_FALSE(*queue_->TakeBack("taken"));
  EXPECT_TRUE(*worker->KeepAlive(taken));
  EXPECT_TRUE(*queue_->TakeBack("waits"));
  EXPECT_FALSE(*queue_->TakeBack("waits"));
  EXPECT_TRUE(queue_->Drop("taken").ok());
  EXPECT_FALSE(*worker->Finish(taken, "result"));
  EXPECT_EQ(*queue_->ListKeys(), std::set<std::string>{"other"});
}

TEST_F(JobQueueTest, WorkersCountWhileTheyGiveSigns) {
  EXPECT_EQ(*queue_->CountWorkers(), WorkerCount());
  const auto one = Hire("one");
  {
    const auto two = Hire("two");
    EXPECT_EQ(*queue_->CountWorkers(), WorkerCount{.able = 2});
  }
  EXPECT_EQ(*queue_->CountWorkers(), WorkerCount{.able = 1});  // Two said goodbye.
  for (const std::string seen : {"now() - interval '1 minute'", "now() + interval '1 minute'"}) {
    Execute("UPDATE workers SET seen = " + seen);
    EXPECT_EQ(*queue_->CountWorkers(), WorkerCount());
  }
  EXPECT_TRUE(*one->KeepAlive(std::nullopt));
  EXPECT_EQ(*queue_->CountWorkers(), WorkerCount{.able = 1});
}

TEST_F(JobQueueTest, WorkersOfAnotherVersionAreCountedApart) {
  const auto one = Hire("one");
  // As a program signs that knows of no versions.
  Execute("INSERT INTO workers (name, seen) VALUES ('older', now())");
  EXPECT_EQ(*queue_->CountWorkers(), (WorkerCount{.able = 1, .of_other_versions = 1}));
  Execute("UPDATE workers SET version = ''");
  EXPECT_TRUE(*one->KeepAlive(std::nullopt));
  EXPECT_EQ(*queue_->CountWorkers(), (WorkerCount{.able = 1, .of_other_versions = 1}));
}

TEST_F(JobQueueTest, TablesOfAnEarlierProgramAreBroughtUpToDate) {
  for (const char* change :
       {"ALTER TABLE workers DROP COLUMN version; ALTER TABLE jobs DROP COLUMN is_urgent",
        "ALTER TABLE workers DROP COLUMN version", "ALTER TABLE jobs DROP COLUMN is_urgent"}) {
    Execute(change);
    EXPECT_TRUE(absl::IsNotFound(JobTaker::Open(server_.url(), site_, "worker").status()));
    store_.reset();
    store_ = std::move(OpenPostgresStore(server_.url(), site_)).value();
    const auto worker = Hire("worker");
    EXPECT_EQ(*store_->jobs()->CountWorkers(), WorkerCount{.able = 1}) << change;
  }
}

// Else a server would wait for what it cannot do.
TEST_F(JobQueueTest, AWorkerThatLacksRightsGivesNoSign) {
  const std::string role = "poor_" + site_, schema = SchemaOfSite(site_);
  const std::string url = "postgresql:///postgres?user=" + role + "&host=" + server_.folder();
  const std::string to_role = " TO \"" + role + "\"";
  Execute("CREATE ROLE \"" + role + "\" LOGIN");
  EXPECT_TRUE(absl::IsPermissionDenied(OpenWorkerStore(url, site_).status()));
  Execute("GRANT USAGE ON SCHEMA \"" + schema + "\"" + to_role);
  const absl::Status none = OpenWorkerStore(url, site_).status();
  EXPECT_TRUE(absl::IsPermissionDenied(none)) << none;
  EXPECT_THAT(none.message(), HasSubstr("needs SELECT on about, "));
  Execute("GRANT USAGE ON SCHEMA \"" + schema + "\"" + to_role +
          "; GRANT SELECT ON ALL TABLES IN SCHEMA \"" + schema + "\"" + to_role +
          "; GRANT INSERT, UPDATE, DELETE ON workers" + to_role + "; GRANT UPDATE ON jobs" +
          to_role);
  const absl::Status lacking = JobTaker::Open(url, site_, "worker").status();
  EXPECT_TRUE(absl::IsPermissionDenied(lacking)) << lacking;
  EXPECT_THAT(lacking.message(), HasSubstr("needs INSERT on features, UPDATE on features;"));
  Execute("GRANT INSERT, UPDATE ON features" + to_role);
  const auto worker = std::move(JobTaker::Open(url, site_, "worker")).value();
  EXPECT_EQ(*queue_->CountWorkers(), WorkerCount{.able = 1});
  Execute("REVOKE SELECT ON submaps FROM \"" + role + "\"");
  EXPECT_TRUE(absl::IsPermissionDenied(worker->KeepAlive(std::nullopt).status()));
}

// A worker knows by that when what it remembers of the map may be of another.
TEST_F(JobQueueTest, AJobThatCameOverAnotherConnectionSaysSo) {
  for (const char* key : {"one", "two", "three"}) ASSERT_TRUE(queue_->Post({key, ""}).ok());
  const auto worker = Hire("worker");
  const int64_t first = worker->Take()->value().connection;
  EXPECT_EQ(worker->Take()->value().connection, first);
  Execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name = '" +
          SchemaOfSite(site_) + " worker'");
  absl::StatusOr<std::optional<TakenJob>> next = absl::UnavailableError("not asked for yet");
  while (absl::IsUnavailable(next.status())) next = worker->Take();
  ASSERT_TRUE(next.ok()) << next.status();
  EXPECT_NE((*next)->connection, first);
}

TEST_F(JobQueueTest, WhatIsUrgentIsTakenFirst) {
  ASSERT_TRUE(queue_->Post({"first", ""}).ok());
  ASSERT_TRUE(queue_->Post({"urgent", "", true}).ok());
  ASSERT_TRUE(queue_->Post({"urgent too", "", true}).ok());
  const auto worker = Hire("worker");
  EXPECT_EQ(worker->Take()->value().key, "urgent");
  EXPECT_EQ(worker->Take()->value().key, "urgent too");
  EXPECT_EQ(worker->Take()->value().key, "first");
}

TEST_F(JobQueueTest, ListsTheKeysOfAllThatIsOnIt) {
  const auto worker = Hire("worker");
  ASSERT_TRUE(queue_->Post({"done", ""}).ok());
  EXPECT_TRUE(*worker->Finish(worker->Take()->value(), "result"));
  ASSERT_TRUE(queue_->Post({"waits", ""}).ok());
  EXPECT_EQ(*queue_->ListKeys(), (std::set<std::string>{"done", "waits"}));
}

TEST_F(JobQueueTest, RowsThatNoWorkerWillEverTakeAreNotThere) {
  for (const std::string change :
       {"state = 'taken', lease_until = NULL", "state = 'taken', lease_until = 'infinity'",
        "version = 'another'"}) {
    ASSERT_TRUE(queue_->Post({"pair", ""}).ok());
    EXPECT_EQ(queue_->ListKeys()->size(), 1u);
    Execute("UPDATE jobs SET " + change);
    EXPECT_EQ(queue_->ListKeys()->size(), 0u) << change;
  }
}

TEST_F(JobQueueTest, JobsOfAnotherVersionAreLeftAloneAndTheNextServerClearsThem) {
  ASSERT_TRUE(queue_->Post({"pair", ""}).ok());
  Execute("UPDATE jobs SET version = 'another'");
  EXPECT_EQ(*Hire("worker")->Take(), std::nullopt);
  EXPECT_EQ(queue_->ListAll()->size(), 1u);
  store_.reset();
  const auto next = std::move(OpenPostgresStore(server_.url(), site_)).value();
  EXPECT_TRUE(next->jobs()->ListAll()->empty());
}

TEST_F(JobQueueTest, AServerThatLostTheSitePostsNothing) {
  Execute("UPDATE owners SET is_current = FALSE");
  EXPECT_FALSE(queue_->Post({"pair", ""}).ok());
  EXPECT_TRUE(queue_->ListAll()->empty());
}

// Both were told by whoever made the tables what others may.
TEST_F(JobQueueTest, ServersOfAnotherRoleUseTheTablesAsFarAsTheyMay) {
  const std::string role = "helper_" + site_, schema = SchemaOfSite(site_);
  const std::string url = "postgresql:///postgres?user=" + role + "&host=" + server_.folder();
  Execute("CREATE ROLE \"" + role + "\" LOGIN; GRANT ALL ON SCHEMA \"" + schema + "\" TO \"" +
          role + "\"; GRANT ALL ON ALL TABLES IN SCHEMA \"" + schema + "\" TO \"" + role +
          "\"; GRANT ALL ON ALL SEQUENCES IN SCHEMA \"" + schema + "\" TO \"" + role + "\"");
  store_.reset();
  {
    const auto other = OpenPostgresStore(url, site_);
    ASSERT_TRUE(other.ok()) << other.status();
    EXPECT_TRUE((*other)->jobs()->Post({"pair", ""}).ok());
  }
  Execute("REVOKE ALL ON jobs FROM \"" + role + "\"");
  std::string problem;
  const auto other = OpenPostgresStore(
      url, site_, {.on_problem = [&problem](const std::string& told) { problem = told; }});
  ASSERT_TRUE(other.ok()) << other.status();
  EXPECT_EQ((*other)->jobs(), nullptr);
  EXPECT_THAT(problem, HasSubstr("workers are not used"));
}

TEST_F(JobQueueTest, AWorkersStoreKeepsFeaturesAndChangesNothingElse) {
  ASSERT_TRUE(
      store_->Write({.sessions = {MakeSession("alice-1")}, .submaps = {MakeSubmap("alice-1", 0)}})
          .ok());
  const auto store = std::move(OpenWorkerStore(server_.url(), site_)).value();
  const SubmapId id{SessionId("alice-1"), 0};
  EXPECT_EQ((*store->GetSubmap(id))->points.size(), 600u);
  EXPECT_TRUE(store->PutFeatures(MakeFeatures(id, "kind", "bytes")).ok());
  EXPECT_EQ(*store_->GetFeatures(id, "kind"), "bytes");
  EXPECT_TRUE(absl::IsFailedPrecondition(store->Write({.sessions = {MakeSession("bob-1")}})));
  EXPECT_TRUE(absl::IsFailedPrecondition(store->DeleteSession(SessionId("alice-1"))));
  EXPECT_EQ(store_->ListSessions()->size(), 1u);
}

TEST_F(JobQueueTest, AWorkerNeedsASiteOfItsOwnVersion) {
  EXPECT_TRUE(absl::IsNotFound(OpenWorkerStore(server_.url(), "nowhere").status()));
  Execute("UPDATE about SET version = version - 1");
  EXPECT_TRUE(absl::IsFailedPrecondition(OpenWorkerStore(server_.url(), site_).status()));
  Execute("UPDATE about SET version = version + 2");
  EXPECT_TRUE(absl::IsFailedPrecondition(OpenWorkerStore(server_.url(), site_).status()));
}

}  // namespace
}  // namespace isthmus::storage
