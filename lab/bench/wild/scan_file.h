// Scans on disk, packed, to be read one by one.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/pose.h"
#include "core/scan.h"

namespace isthmus::bench {

// The part of a scan that is kept beside its points.
struct ScanEntry {
  uint64_t offset = 0, bytes = 0;
  uint32_t points = 0;
  bool has_ring = false, has_time = false;
  int64_t end_stamp_ns = 0;
  double pose[7] = {};  // T_world_sensor: x y z, quaternion x y z w.
};

// Writes a file beside its place and moves it there when it is whole. Not thread safe.
class ScanFileWriter {
 public:
  // `title` is a line of text for the reader.
  ScanFileWriter(const std::string& path, const std::string& title);

  absl::Status Add(const Scan& scan, const Pose& T_world_sensor);
  // Nothing is there before.
  absl::Status Finish();

 private:
  std::string path_, temporary_, title_;
  std::ofstream out_;
  std::vector<ScanEntry> entries_;
  uint64_t written_ = 0;
};

// Thread safe.
class ScanFile {
 public:
  // NotFound if there is none, DataLoss if it is not whole.
  static absl::StatusOr<std::shared_ptr<ScanFile>> Open(const std::string& path);

  const std::string& title() const { return title_; }
  int scans() const { return static_cast<int>(entries_.size()); }
  int64_t end_stamp_ns(int index) const { return entries_[index].end_stamp_ns; }
  Pose Truth(int index) const;
  // Bit for bit what was written, but for the sequence. DataLoss if the file is damaged.
  absl::StatusOr<Scan> Read(int index);

 private:
  std::string path_, title_;
  std::vector<ScanEntry> entries_;
  Mutex mutex_;
  std::ifstream in_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::bench
