// A server that only reads, beside the one that has the map: processes, sockets and PostgreSQL.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "client/library/client.h"
#include "tests/faults/harness/answers.h"
#include "tests/faults/harness/or_throw.h"
#include "tests/faults/harness/robot.h"
#include "tests/faults/harness/test_setup.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/server/main/child_process.h"

namespace isthmus::faults {
namespace {

using testing::HasSubstr;

// When each revision of a server's map was there to be read.
class MapClock {
 public:
  explicit MapClock(const std::string& address)
      : client_(OrThrow(client::Client::Connect(PatientClient(address)))), thread_([this] {
          client_
              ->WatchMap({}, 0,
                         [this](const MapStep& step) {
                           MutexLock lock(&mutex_);
                           seen_s_.try_emplace(step.mark.revision, NowS());
                           changed_.SignalAll();
                           return !is_over_;
                         })
              .IgnoreError();
        }) {}
  // After End(), and a change of the map: a watch ends with its next step.
  ~MapClock() { thread_.join(); }
  MapClock(const MapClock&) = delete;
  MapClock& operator=(const MapClock&) = delete;

  void End() {
    MutexLock lock(&mutex_);
    is_over_ = true;
  }
  void WaitFor(int64_t revision) {
    MutexLock lock(&mutex_);
    while (seen_s_.empty() || seen_s_.rbegin()->first < revision) changed_.Wait(&mutex_);
  }
  std::map<int64_t, double> seen_s() {
    MutexLock lock(&mutex_);
    return seen_s_;
  }

 private:
  const std::unique_ptr<client::Client> client_;
  Mutex mutex_;
  CondVar changed_;
  bool is_over_ ABSL_GUARDED_BY(mutex_) = false;
  std::map<int64_t, double> seen_s_ ABSL_GUARDED_BY(mutex_);
  std::thread thread_;
};

class ReplicaTest : public testing::Test {
 protected:
  void SetUp() override {
    database_ = storage::PostgresServer::Start();
    ASSERT_NE(database_, nullptr);
    test_ = setup_.get();
    test_.store = database_->url();
    test_.robots = 2;
    owner_ = NewServer(test_, "owner");
    replica_ = Launch({"--replica"});
    ASSERT_THAT(replica_->ReadLine(), HasSubstr("listening on")) << replica_->Errors();
  }
  std::unique_ptr<ChildProcess> Launch(std::vector<std::string> more) const {
    more.insert(more.begin(), {"--data", setup_.Path("replica"), "--listen", address(), "--config",
                               setup_.Path("owner") + "/config.yaml", "--store", test_.store});
    return std::make_unique<ChildProcess>(test_.server, more, setup_.Path("replica-log"));
  }
  std::string address() const { return "unix:" + setup_.Path("replica-socket"); }

  // All that both answer is the same, once the replica has the owner's last revision.
  void ExpectSame() const {
    const Answers theirs = AskAll(owner_->address());
    const int64_t revision = InfoOf(owner_->address()).revision;
    while (InfoOf(address()).revision < revision) Rest();
    EXPECT_EQ(Difference(theirs, AskAll(address())), "");
    EXPECT_EQ(InfoOf(address()).revision, InfoOf(owner_->address()).revision);
  }
  static MapInfo InfoOf(const std::string& address) {
    return OrThrow(OrThrow(client::Client::Connect(PatientClient(address)))->GetMapInfo());
  }
  static std::unique_ptr<client::Client> Once(const std::string& address) {
    client::ClientOptions options;
    options.address = address;
    options.backoff.max_attempts = 1;
    return OrThrow(client::Client::Connect(options));
  }
  static void Rest() { std::this_thread::sleep_for(std::chrono::milliseconds(10)); }

  const TestSetup setup_;
  isthmus::faults::Setup test_;
  std::unique_ptr<storage::PostgresServer> database_;
  std::unique_ptr<ServerProcess> owner_;
  std::unique_ptr<ChildProcess> replica_;
};

// Its robots are given the replica's address by mistake, before the owner's.
TEST_F(ReplicaTest, FollowsWhileRobotsStreamToTheOwner) {
  MapClock theirs(owner_->address()), ours(address());
  const std::string both = address() + "," + owner_->address();
  const auto lags_s = [&theirs, &ours] {
    std::vector<double> lags;
    const std::map<int64_t, double> there = theirs.seen_s();
    for (const auto& [revision, seen_s] : ours.seen_s()) {
      const auto before = there.find(revision);
      if (before != there.end() && revision > 0) lags.push_back(seen_s - before->second);
    }
    return lags;
  };
  Fleet fleet(test_, {.addresses = {both}, .period_s = 0.05});
  fleet.Drive();
  while (lags_s().size() < 5) Rest();  // However slowly maps are composed.
  fleet.Stop();
  Report report;
  fleet.Finish(report);
  EXPECT_TRUE(report.broken.empty()) << ToMarkdown({report});
  ExpectSame();
  const int64_t last = InfoOf(owner_->address()).revision;
  theirs.WaitFor(last);
  ours.WaitFor(last);
  std::vector<double> followed = lags_s();
  theirs.End();
  ours.End();
  const auto owner = OrThrow(client::Client::Connect(PatientClient(owner_->address())));
  EXPECT_TRUE(owner->DeleteSession(fleet.robots()[0]->session()).ok());
  std::sort(followed.begin(), followed.end());
  std::printf(
      "%zu revisions, to the replica's map behind the owner's: median %.2f s, most %.2f s\n",
      followed.size(), followed[followed.size() / 2], followed.back());
}

TEST_F(ReplicaTest, ServesWithoutTheOwnerAndRefusesChanges) {
  Fleet fleet(test_, {.addresses = {owner_->address()}, .scans = {24, 24}});
  fleet.Drive();
  Report report;
  fleet.Finish(report);
  const auto owner = OrThrow(client::Client::Connect(PatientClient(owner_->address())));
  ASSERT_TRUE(owner->DeleteSession(fleet.robots()[0]->session()).ok());
  ExpectSame();
  const Answers before = AskAll(address());
  ASSERT_EQ(before.sessions.size(), 1u);
  owner_->Kill();
  EXPECT_EQ(Difference(before, AskAll(address())), "");

  const auto client = Once(address());
  const absl::Status robots = client->CreateSession("carol", "vlp16").status();
  EXPECT_EQ(robots.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(robots.message()), HasSubstr("this server is a replica"));
  const absl::Status persons = client->DeleteSession(before.sessions[0].record.id);
  EXPECT_EQ(persons.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(persons.message()), HasSubstr("ask the server that has it, process "));
  EXPECT_EQ(Difference(before, AskAll(address())), "");

  replica_->Signal(SIGTERM);
  EXPECT_EQ(replica_->Wait(), 0) << replica_->Errors();
}

TEST_F(ReplicaTest, ServesWithoutPostgresAndFollowsAgain) {
  Fleet fleet(test_, {.addresses = {owner_->address()}, .scans = {24, 24}});
  fleet.Drive();
  Report report;
  fleet.Finish(report);
  ExpectSame();
  const int64_t revision = InfoOf(address()).revision;
  database_->Kill();
  while (InfoOf(address()).replica->problem.empty()) Rest();
  EXPECT_EQ(InfoOf(address()).revision, revision);
  EXPECT_GT(OrThrow(Once(address())->ListTiles(0)).tiles.size(), 0u);
  ASSERT_TRUE(database_->StartAgain());
  while (!InfoOf(address()).replica->problem.empty()) Rest();
  const auto owner = OrThrow(client::Client::Connect(PatientClient(owner_->address())));
  absl::Status deleted = absl::UnavailableError("");
  while (absl::IsUnavailable(deleted)) deleted = owner->DeleteSession(fleet.robots()[0]->session());
  EXPECT_TRUE(deleted.ok()) << deleted;
  ExpectSame();
}

TEST_F(ReplicaTest, IsForMapsInADatabaseAndNoSpare) {
  replica_->Signal(SIGTERM);
  EXPECT_EQ(replica_->Wait(), 0);
  const auto both = Launch({"--replica", "--standby"});
  EXPECT_EQ(both->Wait(), 2);
  EXPECT_THAT(both->Errors(), HasSubstr("exclude each other"));
  ChildProcess alone(test_.server, {"--data", setup_.Path("alone"), "--replica"},
                     setup_.Path("alone-log"));
  EXPECT_EQ(alone.Wait(), 2);
  EXPECT_THAT(alone.Errors(), HasSubstr("--replica (storage.replica)"));
  EXPECT_THAT(alone.Errors(), HasSubstr("--store"));
}

}  // namespace
}  // namespace isthmus::faults
