// Outputs by name: files appear whole, streams are written as they stand.
#include "core/io/output_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <thread>

#include "core/io/headed_output.h"

namespace isthmus::io {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class OutputFileTest : public testing::Test {
 protected:
  OutputFileTest() {
    std::string name = (fs::temp_directory_path() / "isthmus_output_XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~OutputFileTest() override { fs::remove_all(folder_); }
  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  fs::path folder_;
};

TEST_F(OutputFileTest, AFileAppearsOnceItIsComplete) {
  OutputFile file(Path("map.pcd"));
  ASSERT_TRUE(file.Open().ok());
  EXPECT_FALSE(file.is_stream());
  ASSERT_TRUE(file.Append("half").ok());
  EXPECT_FALSE(fs::exists(Path("map.pcd")));
  ASSERT_TRUE(file.Open().ok()) << "begun anew";
  ASSERT_TRUE(file.Append("whole").ok());
  ASSERT_TRUE(file.Commit().ok());
  EXPECT_EQ(*ReadFile(Path("map.pcd")), "whole");
}

TEST_F(OutputFileTest, ALinkStaysAndItsTargetIsReplaced) {
  ASSERT_TRUE(WriteFile(Path("target"), "old").ok());
  fs::create_symlink("target", Path("link"));
  ASSERT_TRUE(WriteOutput(Path("link"), "new").ok());
  EXPECT_TRUE(fs::is_symlink(Path("link")));
  EXPECT_EQ(*ReadFile(Path("target")), "new");
}

TEST_F(OutputFileTest, APipeIsWrittenAndStays) {
  ASSERT_EQ(mkfifo(Path("pipe").c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] { got = *ReadFile(Path("pipe")); });
  const absl::Status written = WriteOutput(Path("pipe"), "through");
  reader.join();
  EXPECT_TRUE(written.ok()) << written;
  EXPECT_EQ(got, "through");
  EXPECT_TRUE(fs::is_fifo(Path("pipe")));
}

TEST_F(OutputFileTest, ADescriptorIsWrittenWhereItStands) {
  const int file = open(Path("log").c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_GE(file, 0);
  ASSERT_EQ(write(file, "before ", 7), 7);
  ASSERT_TRUE(WriteOutput("/dev/fd/" + std::to_string(file), "after").ok());
  ASSERT_EQ(write(file, ".", 1), 1) << "the descriptor is still the program's";
  close(file);
  EXPECT_EQ(*ReadFile(Path("log")), "before after.");
}

// Nothing is written to them here: a mistake would replace those of the machine.
TEST_F(OutputFileTest, DevicesAreStreams) {
  for (const char* name : {"/dev/null", "/dev/stdout", "/dev/stderr", "-"}) {
    EXPECT_TRUE(OutputFile(name).is_stream()) << name;
  }
}

TEST_F(OutputFileTest, AStreamCannotBeBegunAnew) {
  const int log = open(Path("log").c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_GE(log, 0);
  OutputFile file("/dev/fd/" + std::to_string(log));
  ASSERT_TRUE(file.Open().ok());
  EXPECT_TRUE(file.is_stream());
  ASSERT_TRUE(file.Open().ok()) << "nothing is written yet";
  ASSERT_TRUE(file.Append("x").ok());
  EXPECT_EQ(file.Open().code(), absl::StatusCode::kFailedPrecondition);
  close(log);
}

TEST_F(OutputFileTest, AMissingFolderIsSaidBeforehand) {
  const absl::Status status = CheckOutput(Path("missing/map.pcd"));
  EXPECT_TRUE(absl::IsNotFound(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("there is no folder " + Path("missing")));
  EXPECT_TRUE(absl::IsFailedPrecondition(CheckOutput(folder_.string())));
  EXPECT_TRUE(CheckOutput(Path("map.pcd")).ok());
  EXPECT_TRUE(CheckOutput("map.pcd").ok()) << "in the current folder";
  EXPECT_TRUE(CheckOutput("-").ok());
  for (const char* name : {"-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"}) {
    EXPECT_TRUE(IsStandardOutput(name)) << name;
  }
  EXPECT_FALSE(IsStandardOutput("/dev/stderr"));
}

TEST_F(OutputFileTest, AHeadIsPutBeforeItsBodyInFilesAndStreams) {
  const int log = open(Path("log").c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_GE(log, 0);
  for (const std::string& path : {Path("map.las"), "/dev/fd/" + std::to_string(log)}) {
    HeadedOutput output(path, 4);
    ASSERT_TRUE(output.Open().ok());
    ASSERT_TRUE(output.Append("body ").ok());
    ASSERT_TRUE(output.Append(std::string(3'000'000, 'x')).ok());
    EXPECT_FALSE(fs::exists(Path("map.las")) && path == Path("map.las"));
    EXPECT_TRUE(absl::IsInvalidArgument(output.Commit("too long")));
    ASSERT_TRUE(output.Commit("head").ok());
  }
  close(log);
  const std::string whole = "headbody " + std::string(3'000'000, 'x');
  EXPECT_TRUE(*ReadFile(Path("map.las")) == whole);
  EXPECT_TRUE(*ReadFile(Path("log")) == whole);
  EXPECT_FALSE(fs::exists(Path("map.las.part")));
}

TEST_F(OutputFileTest, ABodyWithoutItsHeadLeavesNothing) {
  {
    HeadedOutput output(Path("map.las"), 4);
    ASSERT_TRUE(output.Open().ok());
    ASSERT_TRUE(output.Append("body").ok());
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace isthmus::io
