// Links that reset, stall, choke, go away and forget: all scans arrive, once.
#include "tests/faults/link_faults.h"

#include <gtest/gtest.h>

#include "tests/faults/harness/test_setup.h"

namespace isthmus::faults {
namespace {

TEST(LinkFaultsTest, TheMapIsThatOfAnUndisturbedRun) {
  const TestSetup setup;
  faults::Setup two = setup.get();
  two.robots = 2;
  LinkFaultOptions options;
  options.period_s = 0.25;  // Machines that run tests have other work, too.
  const Report report = SpoilLinks(two, options);
  EXPECT_TRUE(report.broken.empty()) << ToMarkdown({report});
  EXPECT_TRUE(report.map.same_bits) << ToMarkdown({report});
  EXPECT_GT(report.scans, 40u);  // Else nothing was tried.
}

}  // namespace
}  // namespace isthmus::faults
