// The robot's program dies and comes back: scans for which Push returned are in the map.
#include "tests/faults/client_kills.h"

#include <gtest/gtest.h>

#include "tests/faults/harness/test_setup.h"

namespace isthmus::faults {
namespace {

TEST(ClientKillsTest, WhatWasPushedIsInTheMap) {
  const TestSetup setup;
  ClientKillOptions options;
  options.kills = 8;
  const Report report = KillClients(setup.get(), options);
  EXPECT_TRUE(report.broken.empty()) << ToMarkdown({report});
  EXPECT_TRUE(report.map.same_bits) << ToMarkdown({report});
  EXPECT_GT(report.scans, 40u);  // Else nothing was tried.
}

}  // namespace
}  // namespace isthmus::faults
