// The disk is full for a while: said, survived, and nothing is lost.
#include "tests/faults/full_disk.h"

#include <gtest/gtest.h>

#include "tests/faults/harness/test_setup.h"

namespace isthmus::faults {
namespace {

TEST(FullDiskTest, IsSaidAndEndsByItself) {
  const TestSetup setup;
  faults::Setup two = setup.get();
  two.robots = 2;
  FullDiskOptions options;
  options.full_s = 1;
  const Report report = FillDisk(two, options);
  EXPECT_TRUE(report.broken.empty()) << ToMarkdown({report});
  EXPECT_TRUE(report.map.same_bits) << ToMarkdown({report});
}

}  // namespace
}  // namespace isthmus::faults
