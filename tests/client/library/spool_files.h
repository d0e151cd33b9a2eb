// Folders for spools in tests, and disks that fail as told.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "client/library/spool/spool_segment.h"
#include "tests/core/io/failing_disk.h"

namespace isthmus::client {

using io::FailingDisk;

// A folder that goes with its test.
class SpoolFiles {
 public:
  SpoolFiles() {
    static int count = 0;
    path_ = testing::TempDir() + "isthmus_spool_" + std::to_string(getpid()) + "_" +
            std::to_string(count++);
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~SpoolFiles() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  SpoolFiles(const SpoolFiles&) = delete;
  SpoolFiles& operator=(const SpoolFiles&) = delete;

  const std::string& path() const { return path_; }

  // The files with scans, the oldest first, wherever below the folder.
  std::vector<std::string> Segments() const {
    std::vector<std::string> found;
    for (const auto& file : std::filesystem::recursive_directory_iterator(path_)) {
      if (file.path().extension() == ".scans") found.push_back(file.path().string());
    }
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  std::string path_;
};

inline std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void WriteFile(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

}  // namespace isthmus::client
