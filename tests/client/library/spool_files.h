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

// A disk with so much room for the files below a folder.
class SmallDisk {
 public:
  SmallDisk(std::string folder, uint64_t bytes) : folder_(std::move(folder)), bytes_(bytes) {}
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  const io::DiskCalls& calls() const { return calls_; }

 private:
  ssize_t Write(int file, const void* data, size_t size, off_t offset) const {
    uint64_t used = size;
    std::error_code gone;  // Files may go at any moment.
    for (std::filesystem::recursive_directory_iterator at(folder_, gone), end; at != end;
         at.increment(gone)) {
      const uint64_t bytes = at->is_regular_file(gone) ? at->file_size(gone) : 0;
      used += gone ? 0 : bytes;
    }
    if (used <= bytes_) return pwrite(file, data, size, offset);
    errno = ENOSPC;
    return -1;
  }

  const std::string folder_;
  const uint64_t bytes_;
  const io::DiskCalls calls_{
      .write = [this](int file, const void* data, size_t size,
                      off_t offset) { return Write(file, data, size, offset); },
      .read = io::DiskCalls::System().read,
      .sync = io::DiskCalls::System().sync,
      .sync_folder = io::DiskCalls::System().sync_folder,
      .free_bytes = io::DiskCalls::System().free_bytes};
};

inline std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void WriteFile(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

}  // namespace isthmus::client
