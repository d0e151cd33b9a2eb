// Two servers on one folder: the second refuses, and does no harm.
#include <gtest/gtest.h>

#include "tests/faults/harness/answers.h"
#include "tests/faults/harness/damage.h"
#include "tests/faults/harness/test_setup.h"

namespace isthmus::faults {
namespace {

TEST(OneServerTest, TheSecondRefusesUntilTheFirstIsGoneHoweverItGoes) {
  const TestSetup setup;
  const std::string folder = MakeDamageMaster(setup.get());
  ServerProcess first(setup.get().server, setup.Path("first"), 8, folder);
  ServerProcess second(setup.get().server, setup.Path("second"), 8, folder);
  ASSERT_TRUE(first.Start()) << first.Log();
  const Answers before = AskAll(first.address());
  EXPECT_FALSE(second.Start());
  EXPECT_EQ(second.exit_code(), 3);
  EXPECT_NE(second.Log().find("is in use by process"), std::string::npos) << second.Log();
  EXPECT_EQ(Difference(before, AskAll(first.address())), "");
  first.Kill();
  ASSERT_TRUE(second.Start()) << second.Log();
  EXPECT_EQ(Difference(before, AskAll(second.address())), "");
}

}  // namespace
}  // namespace isthmus::faults
