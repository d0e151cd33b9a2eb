#include "client/console/exit_code.h"

#include <gtest/gtest.h>

#include "core/io/of_file.h"

namespace isthmus::cli {
namespace {

TEST(ExitCode, NamesInAServersMessageEndNoLine) {
  testing::internal::CaptureStderr();
  const int code = FailServer(absl::NotFoundError("no robot \"c\x1b[31m\nisthmus: forged\""));
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "isthmus: no robot \"c\\x1b[31m\\x0aisthmus: forged\"\n");
  EXPECT_EQ(code, kUnknown);
}

// Lists of what there is in a file have a line each.
TEST(ExitCode, MessagesOfOurOwnMayHaveSeveralLines) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(FailServer(io::OfFile(absl::NotFoundError("there are\n  /points"))), kInput);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "isthmus: there are\n  /points\n");
}

}  // namespace
}  // namespace isthmus::cli
