// A server whose map is in PostgreSQL dies and comes back, and so does PostgreSQL: the map is bit
// for bit that of an undisturbed run in SQLite.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/faults/harness/test_setup.h"
#include "tests/faults/server_kills.h"
#include "tests/faults/takeover.h"
#include "tests/fleet/postgresql/postgres_server.h"

namespace isthmus::faults {
namespace {

class PostgresFaults : public ::testing::Test {
 protected:
  void SetUp() override {
    database_ = storage::PostgresServer::Start();
    ASSERT_NE(database_, nullptr);
    test_ = setup_.get();
    test_.store = database_->url();
  }

  static void ExpectWhole(const Report& report) {
    EXPECT_TRUE(report.broken.empty()) << ToMarkdown({report});
    EXPECT_TRUE(report.map.same_bits) << ToMarkdown({report});
    EXPECT_GT(report.scans, 40u);  // Else nothing was tried.
  }

  const TestSetup setup_;
  std::unique_ptr<storage::PostgresServer> database_;
  isthmus::faults::Setup test_;
};

TEST_F(PostgresFaults, TheServerIsKilled) {
  ServerKillOptions options;
  options.kills = 4;
  ExpectWhole(KillServer(test_, options));
}

TEST_F(PostgresFaults, PostgresIsKilled) {
  Report report;
  report.name = "kill -9 of PostgreSQL";
  const auto server = NewServer(test_, "database_kills");
  // A robot without a spool gives up a server that refuses its scans.
  Fleet fleet(test_,
              {.addresses = {server->address()}, .period_s = 0.1, .spools = server->folder()});
  fleet.Drive();
  constexpr double kSilenceS = 60;
  for (int kill = 0; kill < 3; ++kill) {
    ASSERT_TRUE(fleet.acks().WaitFor(fleet.acks().count() + 40, kSilenceS)) << server->Log();
    database_->Kill();
    ASSERT_TRUE(database_->StartAgain());
  }
  ASSERT_TRUE(fleet.acks().WaitFor(fleet.acks().count() + 40, kSilenceS)) << server->Log();
  Conclude(test_, *server, fleet, report);
  ExpectWhole(report);
}

TEST_F(PostgresFaults, ASpareGoesOnWithTheMap) {
  test_.robots = 2;
  TakeoverOptions options;
  options.servers = 2;
  options.faults = 1;
  options.every_s = 4;  // Some submaps.
  options.always_the_owner = options.only_kills = true;
  options.socket = database_->folder() + "/.s.PGSQL.5432";
  const Report report = TakeOver(test_, options);
  ExpectWhole(report);
  for (const std::string& figure : report.figures) std::printf("%s\n", figure.c_str());
}

TEST_F(PostgresFaults, ASecondServerDoesNotStart) {
  const auto first = NewServer(test_, "first");
  ServerProcess second(test_.server, setup_.Path("second"), 8, "", test_.store);
  EXPECT_FALSE(second.Start());
  EXPECT_EQ(second.exit_code(), 3);
  EXPECT_NE(second.Log().find("one server at a time"), std::string::npos) << second.Log();
  EXPECT_NE(second.Log().find("storage.standby"), std::string::npos) << second.Log();
  EXPECT_EQ(first->Stop(), 0);
}

}  // namespace
}  // namespace isthmus::faults
