// A reader of the scans in an archive.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/ids.h"
#include "core/io/record_log.h"
#include "core/scan_upload.h"

namespace isthmus::storage {

// The scans of a session in order of sequence, each once. Not thread safe; changes nothing.
class ScanReader {
 public:
  // Finds them; reads their heads only. NotFound when the session has none, FailedPrecondition for
  // segments that a newer program made.
  static absl::StatusOr<std::unique_ptr<ScanReader>> Open(const std::string& directory,
                                                          const SessionId& session);

  size_t scans() const { return scans_; }
  // Passes over scans that are damaged; absent at the end. Errors are the disk's.
  absl::StatusOr<std::optional<ScanUpload>> Next();

  // The damage found so far, one line for a person each, the first few.
  const std::vector<std::string>& damage() const { return damage_; }
  int64_t damaged_count() const { return damaged_count_; }
  // Behind the last scan, of one that was not finished when a process died; no damage.
  uint64_t unfinished_bytes() const { return unfinished_bytes_; }

 private:
  struct Place {
    size_t segment = 0;
    io::Record record;
  };

  absl::Status AddSegment(const std::string& path, bool is_last);
  void AddDamage(std::string what);
  // Absent, and `problem` says why, for a damaged one.
  absl::StatusOr<std::optional<ScanUpload>> Read(const Place& place, std::string& problem) const;

  std::vector<std::unique_ptr<io::AppendFile>> segments_;
  std::vector<Place> places_;  // By sequence; copies of a scan beside each other.
  size_t next_ = 0;
  size_t scans_ = 0;
  std::vector<std::string> damage_;
  int64_t damaged_count_ = 0;
  uint64_t unfinished_bytes_ = 0;
};

}  // namespace isthmus::storage
