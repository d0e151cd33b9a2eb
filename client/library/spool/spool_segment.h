// One file of a spool: a header, then scans one after the other. Private to the library.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "core/io/record_log.h"

namespace isthmus::client {

// The head of a segment. Little endian: "ISTHSPL1", u32 version, u32 length of the owner's name,
// u64 first sequence, i64 stamp before it, the name, u32 crc32c of all that.
struct SegmentHeader {
  std::string owner;            // SpoolIdentity::name.
  uint64_t first_sequence = 1;  // The first scan that the segment is for.
  int64_t stamp_before_ns = 0;  // The scan before that one; 0: there was none.
};

// One writer at a time; Read may be called at the same time as anything. Errors are
// io::FileError's. Scans are records whose stamp is that of the scan's end.
class SpoolSegment {
 public:
  static constexpr uint32_t kVersion = 1;

  // In place of a file of that name.
  static absl::StatusOr<std::shared_ptr<SpoolSegment>> Create(const std::string& path,
                                                              const SegmentHeader& header,
                                                              const io::DiskCalls& disk);
  // FailedPrecondition when a newer version wrote it. Where its header is damaged, `expected` takes
  // its place.
  static absl::StatusOr<std::shared_ptr<SpoolSegment>> Open(const std::string& path,
                                                            const SegmentHeader& expected,
                                                            const io::DiskCalls& disk);

  const std::string& path() const { return file_->path(); }
  const SegmentHeader& header() const { return header_; }
  uint64_t bytes() const { return file_->size(); }
  bool headless() const { return header_bytes_ == 0; }  // Its header is damaged.

  // Its scans, by ascending sequence, with gaps where damaged.
  absl::StatusOr<io::RecordIndex> Find(io::Look look) const;

  // Adds a scan behind the last; safe from the death of the process on return, from that of the
  // machine after Sync. Nothing of the scan stays on error.
  absl::StatusOr<io::Record> Append(uint64_t sequence, int64_t end_stamp_ns,
                                    const std::string& payload);
  absl::Status Sync() { return file_->Sync(); }
  // Cuts off what is behind `bytes`.
  absl::Status Truncate(uint64_t bytes) { return file_->Truncate(bytes); }

  // DataLoss when the checksum is wrong.
  absl::StatusOr<std::string> Read(const io::Record& scan) const {
    return io::ReadBody(*file_, scan);
  }

 private:
  explicit SpoolSegment(std::unique_ptr<io::AppendFile> file) : file_(std::move(file)) {}

  absl::Status ReadHeader();

  const std::unique_ptr<io::AppendFile> file_;
  SegmentHeader header_;
  uint64_t header_bytes_ = 0;
};

}  // namespace isthmus::client
