#include "client/report/timing_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/io/file_io.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::report {
namespace {

absl::StatusOr<TimingFile> Read(const std::string& text) {
  const storage::TemporaryFolder folder;
  const std::string path = folder.path() + "/isthmus_timing_test.csv";
  std::filesystem::create_directories(folder.path());
  EXPECT_TRUE(io::WriteFile(path, text).ok());
  return ReadTimingFile(path);
}

TEST(TimingFile, ColumnsAreStagesAndTheirSum) {
  const auto file = Read(
      "scan,features_ms,matching_ms,total_ms,segment,tracking\n"
      "3,1.5,2,4,1,ok\r\n"
      "4,1,2,3.5,1,lost\n");
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_EQ(file->name, "isthmus_timing_test");
  EXPECT_THAT(file->scans, testing::ElementsAre(3, 4));
  ASSERT_EQ(file->stages.size(), 2u);
  EXPECT_EQ(file->stages[0].name, "features");
  EXPECT_THAT(file->stages[0].ms, testing::ElementsAre(1.5, 1));
  EXPECT_THAT(file->total_ms, testing::ElementsAre(4, 3.5));
  EXPECT_THAT(file->tracking, testing::ElementsAre("ok", "lost"));
  EXPECT_THAT(Read("a_ms,b_ms\n1,2\n")->total_ms, testing::ElementsAre(3)) << "their sum";
}

TEST(TimingFile, SaysWhichLineIsWrong) {
  for (const char* text :
       {"", "scan,total_ms\n1,2\n", "a_ms\n", "a_ms,b_ms\n1\n", "a_ms\nfast\n", "a_ms\nnan\n"}) {
    const auto file = Read(text);
    EXPECT_EQ(file.status().code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(file.status().message()), testing::HasSubstr(", line ")) << text;
  }
}

}  // namespace
}  // namespace isthmus::report
