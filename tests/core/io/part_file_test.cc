// Files and folders that appear whole or not at all, and what is said when they cannot.
#include "core/io/part_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/io/directory_lock.h"
#include "core/io/folder.h"

namespace isthmus::io {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class PartFileTest : public testing::Test {
 protected:
  PartFileTest() { fs::create_directories(folder_); }
  ~PartFileTest() override { fs::remove_all(folder_); }

  const std::string folder_ = testing::TempDir() + "part_file_" + std::to_string(getpid());
  const std::string path_ = folder_ + "/file";
};

TEST_F(PartFileTest, TheOldFileStaysUntilTheNewOneIsWhole) {
  ASSERT_TRUE(ReplaceFile(path_, "old").ok());
  {
    PartFile file(path_);
    ASSERT_TRUE(file.Open().ok());
    ASSERT_TRUE(file.Append("half of the new").ok());
    EXPECT_EQ(ReadFile(path_).value(), "old");
    ASSERT_TRUE(file.Open().ok());  // Anew.
    ASSERT_TRUE(file.Append("a").ok());
    ASSERT_TRUE(file.Append("b").ok());
    EXPECT_EQ(ReadFile(path_).value(), "old");
    ASSERT_TRUE(file.Commit().ok());
  }
  EXPECT_EQ(ReadFile(path_).value(), "ab");
  EXPECT_FALSE(fs::exists(path_ + ".part"));
}

TEST_F(PartFileTest, NothingIsLeftOfAFileThatWasGivenUp) {
  {
    PartFile file(path_);
    ASSERT_TRUE(file.Open().ok());
    ASSERT_TRUE(file.Append("half").ok());
  }
  EXPECT_TRUE(fs::is_empty(folder_));
  EXPECT_TRUE(absl::IsNotFound(ReplaceFile(folder_ + "/none/file", "x")));
  fs::create_directories(path_ + "/taken");
  EXPECT_FALSE(ReplaceFile(path_, "x").ok());
  EXPECT_FALSE(fs::exists(path_ + ".part"));
}

TEST_F(PartFileTest, AFolderBecomesItsTargetOrGoes) {
  const std::string part = folder_ + "/part", target = folder_ + "/whole";
  fs::create_directory(part);
  { const PartFolder given_up(part); }
  EXPECT_FALSE(fs::exists(part));
  fs::create_directory(part);
  {
    PartFolder folder(part);
    ASSERT_TRUE(WriteFile(part + "/file", "x").ok());
    ASSERT_TRUE(folder.Become(target).ok());
  }
  EXPECT_EQ(ReadFile(target + "/file").value(), "x");
}

TEST_F(PartFileTest, NumbersAreListedInOrder) {
  for (const char* name : {"10.log", "9.log", "000008.log", "x.log", "7.txt", "0.log", ".log"}) {
    ASSERT_TRUE(WriteFile(folder_ + "/" + name, "").ok());
  }
  EXPECT_THAT(ListNumbers(folder_, ".log").value(), testing::ElementsAre(8, 9, 10));
  EXPECT_TRUE(absl::IsNotFound(ListNumbers(folder_ + "/none", "").status()));
}

TEST_F(PartFileTest, ALockNamesItsHolder) {
  const LockKind kind{"lock", "the box"};
  auto first = DirectoryLock::Acquire(folder_ + "/a/b", kind);
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = DirectoryLock::Acquire(folder_ + "/a/b", kind);
  EXPECT_TRUE(absl::IsFailedPrecondition(second.status()));
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr("b is in use by process " + std::to_string(getpid())));
  fs::remove(folder_ + "/a/b/lock");
  EXPECT_TRUE(absl::IsFailedPrecondition(DirectoryLock::Acquire(folder_ + "/a/b", kind).status()))
      << "removing the file lets nobody in";
  first->reset();
  EXPECT_TRUE(DirectoryLock::Acquire(folder_ + "/a/b", kind).ok());
  ASSERT_TRUE(WriteFile(path_, "").ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(DirectoryLock::Acquire(path_, kind).status()));
}

TEST(FileErrorTest, SaysWhatToDo) {
  const auto full = FileError("write", "a/b", ENOSPC);
  EXPECT_TRUE(absl::IsResourceExhausted(full));
  EXPECT_EQ(full.message(), "cannot write a/b: No space left on device; make room on its disk");
  EXPECT_TRUE(absl::IsResourceExhausted(FileError("write", "a", EDQUOT)));
  EXPECT_TRUE(absl::IsPermissionDenied(FileError("write", "a", EROFS)));
  EXPECT_TRUE(absl::IsPermissionDenied(FileError("write", "a", EACCES)));
  EXPECT_TRUE(absl::IsUnavailable(FileError("write", "a", EIO)));
}

}  // namespace
}  // namespace isthmus::io
