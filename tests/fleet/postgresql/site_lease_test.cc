// One server after the other has a site: taken over from one that died, is paused or cut off, and
// never written by two.
#include "fleet/postgresql/site_lease.h"

#include <absl/strings/match.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "core/concurrency/mutex.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/postgresql.h"
#include "tests/faults/harness/proxy.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/fleet/postgresql/store_process.h"
#include "tests/storage/records.h"

namespace isthmus::storage {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;
using ::testing::HasSubstr;

using Time = steady_clock::time_point;
using Store = absl::StatusOr<std::unique_ptr<MapStore>>;

// The lease of a server that died, for which nobody has to wait; and of one that is to keep its
// site on a machine that is busy with other tests.
constexpr milliseconds kLong{60'000};
// The lease of a server that is to be taken for dead. It loses its site too where the machine
// stalls for so long.
constexpr milliseconds kShort{2000};

// A store that waits for its site on a thread of its own.
class Spare {
 public:
  // `on_overdue` is called before it ends an owner.
  Spare(const std::string& url, const std::string& site, milliseconds lease = kLong,
        std::function<void()> on_overdue = nullptr) {
    PostgresOptions options;
    options.on_problem = [on_overdue](const std::string& problem) {
      if (on_overdue && absl::StrContains(problem, "has not renewed")) on_overdue();
    };
    options.lease.length = lease;
    options.lease.on_wait = [this](const std::string& why) {
      MutexLock lock(&mutex_);
      reasons_.insert(why);
      ++looks_;
      changed_.SignalAll();
      return !is_given_up_;
    };
    options.lease.on_lost = [this](const std::string& why) {
      MutexLock lock(&mutex_);
      lost_ = why;
      lost_at_ = steady_clock::now();
      changed_.SignalAll();
    };
    opening_ = std::thread([this, url, site, options] {
      Store store = OpenPostgresStore(url, site, options);
      MutexLock lock(&mutex_);
      store_ = std::move(store);
      opened_at_ = steady_clock::now();
      changed_.SignalAll();
    });
  }
  ~Spare() {
    {
      MutexLock lock(&mutex_);
      is_given_up_ = true;
    }
    opening_.join();
  }

  // Waits until it has looked so many times more, or is open.
  void AwaitLooks(int count) {
    MutexLock lock(&mutex_);
    const int until = looks_ + count;
    while (looks_ < until && !opened_at_) changed_.Wait(&mutex_);
  }
  bool IsOpen() const { return opened_at().has_value(); }
  std::optional<Time> opened_at() const {
    MutexLock lock(&mutex_);
    return opened_at_;
  }
  // Waits until it owns the site.
  MapStore& store() {
    MutexLock lock(&mutex_);
    while (!opened_at_) changed_.Wait(&mutex_);
    return **store_;
  }
  void Close() {
    store();
    Store store = absl::UnknownError("closed");
    MutexLock lock(&mutex_);
    std::swap(store, store_);
  }
  // Waits until it is told that it lost the site.
  Time AwaitLoss() {
    MutexLock lock(&mutex_);
    while (lost_.empty()) changed_.Wait(&mutex_);
    return lost_at_;
  }
  std::string lost() const {
    MutexLock lock(&mutex_);
    return lost_;
  }
  std::set<std::string> reasons() const {
    MutexLock lock(&mutex_);
    return reasons_;
  }

 private:
  mutable Mutex mutex_;
  CondVar changed_;
  std::set<std::string> reasons_ ABSL_GUARDED_BY(mutex_);
  std::string lost_ ABSL_GUARDED_BY(mutex_);
  Time lost_at_ ABSL_GUARDED_BY(mutex_);
  int looks_ ABSL_GUARDED_BY(mutex_) = 0;
  bool is_given_up_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<Time> opened_at_ ABSL_GUARDED_BY(mutex_);
  Store store_ ABSL_GUARDED_BY(mutex_) = absl::UnknownError("not opened");
  std::thread opening_;
};

std::set<std::string> IdsIn(const MapStore& store) {
  std::set<std::string> ids;
  const auto sessions = store.ListSessions();
  EXPECT_TRUE(sessions.ok()) << sessions.status();
  if (!sessions.ok()) return ids;
  for (const SessionRecord& record : *sessions) ids.insert(record.id.value());
  return ids;
}

class SiteLeaseTest : public ::testing::Test {
 protected:
  StoreProcessOptions Owner(milliseconds lease) const {
    StoreProcessOptions options;
    options.url = server_.url();
    options.site = site_;
    options.lease = lease;
    return options;
  }

  PostgresServer& server_ = PostgresServer::Shared();
  const std::string site_ = server_.NewSite();
};

TEST_F(SiteLeaseTest, ASpareHasTheSiteAsSoonAsItsOwnerIsKilled) {
  StoreProcess owner(Owner(kLong));
  std::vector<std::string> stored = {*owner.Next()};
  Spare spare(server_.url(), site_);
  spare.AwaitLooks(3);
  EXPECT_FALSE(spare.IsOpen());
  EXPECT_THAT(*spare.reasons().begin(), HasSubstr("is open in another server, process "));
  owner.Signal(SIGKILL);
  const auto killed = steady_clock::now();
  EXPECT_TRUE(spare.store().Write({.sessions = {MakeSession("spare-1")}}).ok());
  EXPECT_LT(steady_clock::now() - killed, kLong / 4);
  for (const std::string& id : owner.Rest()) stored.push_back(id);
  const std::set<std::string> found = IdsIn(spare.store());
  for (const std::string& id : stored) EXPECT_TRUE(found.contains(id)) << id;
}

TEST_F(SiteLeaseTest, AnOwnerThatRenewsItsLeaseKeepsTheSite) {
  StoreProcess owner(Owner(seconds(4)));
  ASSERT_TRUE(owner.Next());
  Spare spare(server_.url(), site_);
  spare.AwaitLooks(24);  // Six seconds.
  EXPECT_FALSE(spare.IsOpen());
}

TEST_F(SiteLeaseTest, NothingIsWrittenByAnOwnerThatWasPaused) {
  for (int round = 0; round < 3; ++round) {
    const std::string site = server_.NewSite();
    StoreProcessOptions options = Owner(kShort);
    options.site = site;
    StoreProcess owner(options);
    for (int i = 0; i < 10 + round; ++i) ASSERT_TRUE(owner.Next());
    Spare spare(server_.url(), site);
    spare.AwaitLooks(2);
    owner.Signal(SIGSTOP);
    ASSERT_TRUE(spare.store().Write({.sessions = {MakeSession("spare-1")}}).ok());
    const std::set<std::string> taken_over = IdsIn(spare.store());
    owner.Signal(SIGCONT);
    std::set<std::string> told = {"spare-1"};
    for (const std::string& id : owner.Rest()) told.insert(id);
    EXPECT_EQ(owner.Wait(), kLostTheSite);
    EXPECT_EQ(IdsIn(spare.store()), taken_over);
    for (const std::string& id : told) EXPECT_TRUE(taken_over.contains(id)) << id;
    EXPECT_EQ(spare.lost(), "");
  }
}

// It may hold locks and be in the middle of a transaction: the epoch is enough.
TEST_F(SiteLeaseTest, AnOwnerWhoseConnectionsMayNotBeEndedWritesNothingEither) {
  StoreProcess owner(Owner(kShort));
  ASSERT_TRUE(owner.Next());
  const std::string schema = SchemaOfSite(site_), role = "spare_of_" + site_;
  ASSERT_TRUE(server_.Execute("CREATE ROLE " + role + " LOGIN; GRANT ALL ON SCHEMA " + schema +
                              " TO " + role + "; GRANT ALL ON ALL TABLES IN SCHEMA " + schema +
                              " TO " + role + "; GRANT ALL ON ALL SEQUENCES IN SCHEMA " + schema +
                              " TO " + role));
  Spare spare("postgresql:///postgres?user=" + role + "&host=" + server_.folder(), site_);
  spare.AwaitLooks(2);
  owner.Signal(SIGSTOP);
  ASSERT_TRUE(spare.store().Write({.sessions = {MakeSession("spare-1")}}).ok());
  const std::set<std::string> taken_over = IdsIn(spare.store());
  owner.Signal(SIGCONT);
  EXPECT_EQ(owner.Wait(), kLostTheSite);
  EXPECT_EQ(IdsIn(spare.store()), taken_over);
  EXPECT_EQ(spare.lost(), "");
  // Before long it has the lock as well, so that nobody else takes the site for free.
  const auto database = PostgresConnection::Open({server_.url(), schema, "test"}).value();
  const std::string locks_of_spare =
      "SELECT count(*) FROM pg_locks JOIN pg_stat_activity USING (pid) WHERE locktype = 'advisory' "
      "AND usename = '" +
      role + "'";
  while (*database->ReadNumber(locks_of_spare) == 0) {
  }
  EXPECT_TRUE(absl::IsFailedPrecondition(OpenPostgresStore(server_.url(), site_).status()));
}

TEST_F(SiteLeaseTest, WhoIsCutOffGivesUpBeforeAnotherBegins) {
  faults::Proxy link(server_.folder() + "/.s.PGSQL.5432", 1);
  Spare owner("postgresql://isthmus@" + link.address() + "/postgres", site_, kShort);
  ASSERT_TRUE(owner.store().Write({.sessions = {MakeSession("owner-1")}}).ok());
  Spare spare(server_.url(), site_);
  spare.AwaitLooks(2);
  link.Stall(true);
  const Time lost = owner.AwaitLoss();
  EXPECT_THAT(owner.lost(), HasSubstr("no answer came"));
  ASSERT_TRUE(spare.store().Write({.sessions = {MakeSession("spare-1")}}).ok());
  EXPECT_LT(lost, *spare.opened_at());
  link.Stall(false);
  EXPECT_EQ(owner.store().Write({.sessions = {MakeSession("owner-2")}}).code(),
            absl::StatusCode::kUnavailable);
  EXPECT_EQ(IdsIn(spare.store()), (std::set<std::string>{"owner-1", "spare-1"}));
}

TEST_F(SiteLeaseTest, OfManySparesOneHasTheSite) {
  for (const int how : {SIGKILL, SIGSTOP}) {
    StoreProcessOptions options = Owner(kShort);
    options.site = server_.NewSite();
    StoreProcess mine(options);
    ASSERT_TRUE(mine.Next());
    std::vector<std::unique_ptr<Spare>> spares;
    for (int i = 0; i < 3; ++i) {
      spares.push_back(std::make_unique<Spare>(server_.url(), options.site));
      spares.back()->AwaitLooks(1);
    }
    mine.Signal(how);
    while (!spares.empty()) {
      size_t winner = 0;
      while (!spares[winner]->IsOpen()) winner = (winner + 1) % spares.size();
      const std::string id = "spare-" + std::to_string(spares.size());
      EXPECT_TRUE(spares[winner]->store().Write({.sessions = {MakeSession(id)}}).ok());
      for (size_t i = 0; i < spares.size(); ++i) {
        if (i == winner) continue;
        spares[i]->AwaitLooks(4);
        EXPECT_FALSE(spares[i]->IsOpen());
      }
      EXPECT_EQ(spares[winner]->lost(), "");
      spares[winner]->Close();
      spares.erase(spares.begin() + static_cast<int>(winner));
    }
  }
}

// It would end the lock of a server that was sooner.
TEST_F(SiteLeaseTest, WhoComesLateToEndAnOwnerEndsNoOther) {
  StoreProcess owner(Owner(kShort));
  ASSERT_TRUE(owner.Next());
  std::promise<void> others_turn;
  const std::shared_future<void> is_late = others_turn.get_future().share();
  std::promise<void> saw_owner_overdue;
  Spare late(server_.url(), site_, kLong, [&] {
    saw_owner_overdue.set_value();
    is_late.wait();
  });
  late.AwaitLooks(1);
  owner.Signal(SIGSTOP);
  saw_owner_overdue.get_future().wait();
  Spare sooner(server_.url(), site_);
  ASSERT_TRUE(sooner.store().Write({.sessions = {MakeSession("sooner-1")}}).ok());
  const auto database = PostgresConnection::Open({server_.url(), SchemaOfSite(site_), "test"});
  ASSERT_TRUE(database.ok()) << database.status();
  const std::string owner_of_lock =
      "SELECT pid::bigint FROM pg_stat_activity WHERE application_name = '" + SchemaOfSite(site_) +
      " owner' AND pid IN (SELECT pid FROM pg_locks WHERE locktype = 'advisory' AND granted)";
  const int64_t before = (*database)->ReadNumber(owner_of_lock).value();
  others_turn.set_value();
  late.AwaitLooks(2);
  EXPECT_FALSE(late.IsOpen());
  EXPECT_EQ(*(*database)->ReadNumber(owner_of_lock), before);
}

TEST_F(SiteLeaseTest, ClocksOfServersDoNotMatter) {
  for (const seconds ahead : {seconds(86'400), seconds(-86'400)}) {
    StoreProcessOptions options = Owner(kShort);
    options.site = server_.NewSite();
    options.clock_ahead = ahead;
    StoreProcess owner(options);
    ASSERT_TRUE(owner.Next());
    Spare spare(server_.url(), options.site);
    spare.AwaitLooks(4);  // Half a lease: it would be overdue at once.
    EXPECT_FALSE(spare.IsOpen());
    owner.Signal(SIGSTOP);
    const auto paused = steady_clock::now();
    EXPECT_TRUE(spare.store().Write({.sessions = {MakeSession("spare-1")}}).ok());
    EXPECT_LT(steady_clock::now() - paused, seconds(30));
    EXPECT_GT(steady_clock::now() - paused, kShort / 2);
  }
}

// As where PostgreSQL is away again just then.
TEST_F(SiteLeaseTest, ASpareThatWonTheSiteAndCannotOpenItWaitsOn) {
  ASSERT_TRUE(OpenPostgresStore(server_.url(), site_).ok());
  const std::string role = "\"few_" + site_ + "\"",
                    schema = "SCHEMA \"" + SchemaOfSite(site_) + "\"";
  const std::string rights = "GRANT ALL ON ";
  ASSERT_TRUE(server_.Execute("CREATE ROLE " + role + " LOGIN CONNECTION LIMIT 1; " + rights +
                              schema + " TO " + role + "; " + rights + "ALL TABLES IN " + schema +
                              " TO " + role + "; " + rights + "ALL SEQUENCES IN " + schema +
                              " TO " + role));
  PostgresOptions options;
  int refused = 0;
  options.lease.on_wait = [&](const std::string& why) {
    if (why.find("too many connections") != std::string::npos && ++refused == 1) {
      EXPECT_TRUE(server_.Execute("ALTER ROLE " + role + " CONNECTION LIMIT 20"));
    }
    return true;
  };
  const auto store = OpenPostgresStore(
      "postgresql:///postgres?user=few_" + site_ + "&host=" + server_.folder(), site_, options);
  ASSERT_TRUE(store.ok()) << store.status();
  EXPECT_EQ(refused, 1);
  EXPECT_TRUE((*store)->Write({.sessions = {MakeSession("spare-1")}}).ok());
}

TEST_F(SiteLeaseTest, ASpareOutlastsPostgresAndLeavesTheSiteToItsOwner) {
  const auto server = PostgresServer::Start();
  ASSERT_NE(server, nullptr);
  Spare owner(server->url(), "");
  ASSERT_TRUE(owner.store().Write({.sessions = {MakeSession("owner-1")}}).ok());
  Spare spare(server->url(), "");
  spare.AwaitLooks(1);
  server->Kill();
  spare.AwaitLooks(2);
  ASSERT_TRUE(server->StartAgain());
  spare.AwaitLooks(30);  // Longer than it gives way for.
  ASSERT_FALSE(spare.IsOpen());
  EXPECT_EQ(owner.lost(), "");
  while (!owner.store().Write({.sessions = {MakeSession("owner-2")}}).ok()) {
  }
  owner.Close();
  EXPECT_EQ(IdsIn(spare.store()).size(), 2u);
}

TEST_F(SiteLeaseTest, WhoDoesNotStandByIsRefusedAndToldHow) {
  Spare owner(server_.url(), site_);
  owner.store();
  const auto second = OpenPostgresStore(server_.url(), site_);
  EXPECT_TRUE(absl::IsFailedPrecondition(second.status()));
  EXPECT_THAT(std::string(second.status().message()), HasSubstr("storage.standby"));
}

}  // namespace
}  // namespace isthmus::storage
