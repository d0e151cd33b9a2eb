// Whatever a recording is, it is told by its first bytes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "client/readers/recording.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class OpenRecordingTest : public testing::Test {
 protected:
  OpenRecordingTest() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / "isthmus_open_recording" / info->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  std::string Error(const std::string& path) const {
    return std::string(OpenRecording(path).status().message());
  }
  fs::path folder_;
};

TEST_F(OpenRecordingTest, ExtensionsDoNotMatter) {
  for (const char* name : {"drive_none.bag", "drive_lz4.mcap"}) {
    const fs::path fixture = fs::path(ISTHMUS_READERS_DATA) / name;
    if (!fs::exists(fixture)) continue;
    fs::copy_file(fixture, folder_ / "renamed.dat", fs::copy_options::overwrite_existing);
    const auto recording = OpenRecording((folder_ / "renamed.dat").string());
    ASSERT_TRUE(recording.ok()) << name << recording.status();
    EXPECT_FALSE((*recording)->scan_topics().empty());
  }
}

TEST_F(OpenRecordingTest, SaysWhatIsNoRecording) {
  std::ofstream(folder_ / "notes.doc") << "not a recording at all";
  EXPECT_THAT(Error((folder_ / "notes.doc").string()), HasSubstr("no recording"));
  EXPECT_THAT(Error((folder_ / "none.bag").string()), HasSubstr("none.bag"));
  EXPECT_TRUE(absl::IsNotFound(OpenRecording((folder_ / "none.bag").string()).status()));
  EXPECT_THAT(Error(folder_.string()), HasSubstr("holds no scans"));
  EXPECT_TRUE(absl::IsInvalidArgument(OpenRecording("tcp://:2368").status()));
}

}  // namespace
}  // namespace isthmus::readers
