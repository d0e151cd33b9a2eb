// A backup made while robots push, and the map that it gives when it is all that is left.
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>

#include "tests/faults/harness/answers.h"
#include "tests/faults/harness/room_robot.h"
#include "tests/faults/harness/test_setup.h"

namespace isthmus::faults {
namespace {

int RunBackup(const TestSetup& setup, const std::string& address, const std::string& target) {
  ChildProcess backup(ISTHMUS_CLI, {"backup", "--server", address, target}, setup.Path("errors"));
  backup.ReadAll();
  return backup.Wait();
}

TEST(BackupTest, ServesWhatItHoldsWhenTheFolderIsLost) {
  const TestSetup setup;
  faults::Setup two = setup.get();
  two.robots = 2;
  ServerProcess server(two.server, setup.Path("server"));
  ASSERT_TRUE(server.Start()) << server.Log();
  std::vector<uint64_t> pushed, durable;
  {
    Fleet fleet(two, {.addresses = {server.address()}});
    fleet.Drive();
    ASSERT_TRUE(fleet.acks().WaitFor(50, 60));
    durable = {fleet.robots()[0]->durable(), fleet.robots()[1]->durable()};
    ASSERT_EQ(RunBackup(setup, server.address(), setup.Path("backup")), 0);
    fleet.Stop();
    Report report;
    fleet.Finish(report);
    EXPECT_TRUE(report.broken.empty()) << report.broken.front();
    pushed = fleet.pushed();
    server.Kill();
    std::filesystem::remove_all(server.data());

    ServerProcess restored(two.server, setup.Path("restored"), 8, setup.Path("backup"));
    ASSERT_TRUE(restored.Start()) << restored.Log();
    const Answers answers = AskAll(restored.address());
    ASSERT_EQ(answers.sessions.size(), 2u);
    for (size_t i = 0; i < 2; ++i) EXPECT_GE(answers.sessions[i].durable_sequence, durable[i]);
    restored.Kill();
  }
  // All that is in it is as in a run without any of this.
  const MapDifference difference =
      Compare(UndisturbedMap(two, pushed), ReadStoredMap(setup.Path("backup")));
  EXPECT_GT(difference.scans, 0u);
  EXPECT_GE(difference.scans, durable[0] + durable[1]);
  EXPECT_EQ(difference.odd_scans, 0u);
  EXPECT_EQ(difference.other_points, 0u);
  EXPECT_EQ(difference.max_m, 0);
}

TEST(BackupTest, IsSoundAndNothingIsLeftOfItsMaking) {
  const TestSetup setup;
  ServerProcess server(setup.get().server, setup.Path("server"));
  ASSERT_TRUE(server.Start()) << server.Log();
  EXPECT_EQ(RunBackup(setup, server.address(), setup.Path("backup")), 0);
  // Never over another one.
  EXPECT_NE(RunBackup(setup, server.address(), setup.Path("backup")), 0);
  for (const auto& entry : std::filesystem::directory_iterator(server.data())) {
    EXPECT_EQ(entry.path().filename().string().rfind("backup", 0), std::string::npos);
  }
  for (const auto& entry : std::filesystem::directory_iterator(setup.Path(""))) {
    EXPECT_EQ(entry.path().filename().string().find(".part"), std::string::npos);
  }
  ChildProcess check(setup.get().server, {"--check", setup.Path("backup")}, setup.Path("check"));
  EXPECT_NE(check.ReadAll().find("\nsound\n"), std::string::npos);
  EXPECT_EQ(check.Wait(), 0);
}

TEST(BackupTest, WhatADeadServerLeftHalfDoneIsClearedAway) {
  const TestSetup setup;
  ServerProcess server(setup.get().server, setup.Path("server"));
  std::filesystem::create_directories(server.data() + "/backup-1-1.partial-abcdef");
  std::ofstream(server.data() + "/backup-1-1.partial-abcdef/isthmus.db") << "half";
  ASSERT_TRUE(server.Start()) << server.Log();
  EXPECT_FALSE(std::filesystem::exists(server.data() + "/backup-1-1.partial-abcdef"));
}

}  // namespace
}  // namespace isthmus::faults
