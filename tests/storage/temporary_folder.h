// A folder that goes with its test.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace isthmus::storage {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    static int count = 0;
    path_ = ::testing::TempDir() + "isthmus_storage_" + std::to_string(getpid()) + "_" +
            std::to_string(count++);
    std::filesystem::remove_all(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }  // Not made yet.
  std::string database() const { return path_ + "/isthmus.db"; }

 private:
  std::string path_;
};

}  // namespace isthmus::storage
