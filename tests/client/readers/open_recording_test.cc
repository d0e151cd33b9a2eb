// A recording's kind is told by its first bytes.
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

TEST_F(OpenRecordingTest, PartsOfASplitBagAreOneDrive) {
  const fs::path fixture = fs::path(ISTHMUS_READERS_DATA) / "drive_none.bag";
  const auto one = OpenRecording(fixture.string());
  ASSERT_TRUE(one.ok()) << one.status();
  for (const char* part : {"_9", "_10", "_11"}) {
    fs::copy_file(fixture, folder_ / (std::string("drive_2021-10-26-16-21-29") + part + ".bag"));
  }
  std::ofstream(folder_ / "._drive_9.bag") << "of another system";
  const auto drive = OpenRecording(folder_.string());
  ASSERT_TRUE(drive.ok()) << drive.status();
  EXPECT_EQ((*drive)->scan_topics()[0].messages.value(),
            3 * (*one)->scan_topics()[0].messages.value());
  EXPECT_THAT((*drive)->notes(), testing::Contains(HasSubstr("29_9.bag to drive_2021")));
  fs::copy_file(fixture, folder_ / "drive_2021-10-26-16-21-29_13.bag");
  EXPECT_THAT(Error(folder_.string()), HasSubstr("several bags"));
}

TEST_F(OpenRecordingTest, ABagAloneInAFolderIsRead) {
  fs::copy_file(fs::path(ISTHMUS_READERS_DATA) / "drive_none.bag", folder_ / "drive.bag");
  EXPECT_TRUE(OpenRecording(folder_.string()).ok());
  fs::copy_file(folder_ / "drive.bag", folder_ / "other.bag");
  EXPECT_THAT(Error(folder_.string()), HasSubstr("drive.bag, other.bag"));
}

TEST_F(OpenRecordingTest, SaysHowToUnpack) {
  const auto error = [&](const std::string& name, const std::string& bytes) {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return Error((folder_ / name).string());
  };
  EXPECT_THAT(error("a.bag.gz", "\x1F\x8B\x08 and so on"), HasSubstr("`gunzip -k /"));
  EXPECT_THAT(error("a.pcd.zst", "\x28\xB5\x2F\xFD"), HasSubstr("`zstd -d /"));
  EXPECT_THAT(error("a.tar.zst", "\x28\xB5\x2F\xFD"), HasSubstr("`tar --zstd -xf /"));
  EXPECT_THAT(error("a.tgz", "\x1F\x8B\x08 and so on"), HasSubstr("`tar -xzf /"));
  EXPECT_THAT(error("a.las.bz2", "BZh9"), HasSubstr("`bunzip2 -k /"));
  EXPECT_THAT(error("b 1.zip", "PK\x03\x04"), HasSubstr("`unzip '/"));
  EXPECT_THAT(error("a.tar", std::string(257, '\0') + "ustar"), HasSubstr("`tar -xf /"));
}

TEST_F(OpenRecordingTest, SaysHowToUnpackTheScansOfAFolder) {
  std::ofstream(folder_ / "0.pcd.gz", std::ios::binary) << "\x1F\x8B\x08 and so on";
  EXPECT_THAT(Error(folder_.string()), HasSubstr("`gunzip -k " + folder_.string() + "/*.gz`"));
}

}  // namespace
}  // namespace isthmus::readers
