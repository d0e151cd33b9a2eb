// The server dies and comes back: nothing that was durable is lost, nothing counts twice.
#include "tests/faults/server_kills.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/faults/harness/test_setup.h"

namespace isthmus::faults {
namespace {

TEST(ServerKillsTest, TheMapIsThatOfAnUndisturbedRun) {
  const TestSetup setup;
  ServerKillOptions options;
  options.kills = 6;
  const Report report = KillServer(setup.get(), options);
  EXPECT_TRUE(report.broken.empty()) << ToMarkdown({report});
  EXPECT_TRUE(report.map.same_bits) << ToMarkdown({report});
  EXPECT_GT(report.scans, 40u);  // Else nothing was tried.
}

}  // namespace
}  // namespace isthmus::faults
