// Folders for spools in tests, and disks that fail as told.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "client/library/spool_segment.h"

namespace isthmus::client {

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

// A disk with room for so many bytes more, or whose fsync fails.
class FailingDisk {
 public:
  std::optional<size_t> room;  // Absent: as much as there is.
  bool fails_to_sync = false;
  int syncs = 0;

  const DiskCalls& calls() const { return calls_; }

 private:
  ssize_t Write(int file, const void* data, size_t size, off_t offset) {
    if (!room) return pwrite(file, data, size, offset);
    const size_t fits = std::min(size, *room);
    *room -= fits;
    if (fits > 0) return pwrite(file, data, fits, offset);
    errno = ENOSPC;
    return -1;
  }
  int Sync(int file) {
    ++syncs;
    if (!fails_to_sync) return fdatasync(file);
    errno = EIO;
    return -1;
  }

  const DiskCalls calls_{[this](int file, const void* data, size_t size, off_t offset) {
                           return Write(file, data, size, offset);
                         },
                         [this](int file) { return Sync(file); }};
};

}  // namespace isthmus::client
