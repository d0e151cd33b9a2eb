// One file of a spool: a header, then scans one after the other. Private to the library.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace isthmus::client {

// The system calls that may fail for want of a disk; tests put others in their place.
struct DiskCalls {
  std::function<ssize_t(int, const void*, size_t, off_t)> write;  // pwrite(2)
  std::function<int(int)> sync;                                   // fdatasync(2)

  static const DiskCalls& System();
};

// What a segment begins with. Little endian: "ISTHSPL1", u32 version, u32 length of the owner's
// name, u64 first sequence, i64 stamp before it, the name, u32 crc32c of all that.
struct SegmentHeader {
  std::string owner;            // Of whose session the scans are: its request id.
  uint64_t first_sequence = 1;  // Of the first scan that the segment is for.
  int64_t stamp_before_ns = 0;  // Of the scan before that one; 0: there was none.
};

// Where a scan lies. Its record: u32 marker, u32 size, u64 sequence, i64 stamp, u32 crc32c of the
// payload, u32 crc32c of these 28 bytes, payload.
struct SpooledScan {
  uint64_t sequence = 0;
  int64_t end_stamp_ns = 0;
  uint64_t offset = 0;  // Of the payload in the file.
  uint32_t size = 0;    // Of the payload.
  uint32_t crc32c = 0;  // Likewise.
};

// One writer at a time; Read and ReadAll may be called at the same time as anything.
class SpoolSegment {
 public:
  static constexpr uint32_t kVersion = 1;
  static constexpr uint64_t kRecordHeaderBytes = 32;

  // In place of a file of that name. Errors as those of Append.
  static absl::StatusOr<std::shared_ptr<SpoolSegment>> Create(const std::string& path,
                                                              const SegmentHeader& header,
                                                              const DiskCalls& disk);
  // FailedPrecondition when a newer version wrote it. Where its header is damaged, `expected` takes
  // its place.
  static absl::StatusOr<std::shared_ptr<SpoolSegment>> Open(const std::string& path,
                                                            const SegmentHeader& expected,
                                                            const DiskCalls& disk);
  ~SpoolSegment();
  SpoolSegment(const SpoolSegment&) = delete;
  SpoolSegment& operator=(const SpoolSegment&) = delete;

  const std::string& path() const { return path_; }
  const SegmentHeader& header() const { return header_; }
  uint64_t bytes() const { return bytes_; }
  bool headless() const { return header_bytes_ == 0; }  // Its header is damaged.

  struct Contents {
    std::vector<SpooledScan> scans;  // By ascending sequence, with gaps where damaged.
    uint64_t end = 0;                // Of the last of them in the file.
    uint64_t skipped = 0;            // Bytes between them that could not be read.
  };
  // Finds the scans, past what is damaged. Payloads are only looked at if `verify`; one whose
  // checksum is wrong then counts as missing.
  absl::StatusOr<Contents> Find(bool verify) const;

  // Adds a scan behind the last; safe from the death of the process on return, from that of the
  // machine after Sync. ResourceExhausted when the disk is full, Unavailable when it fails; nothing
  // of the scan stays then.
  absl::StatusOr<SpooledScan> Append(uint64_t sequence, int64_t end_stamp_ns,
                                     const std::string& payload);
  absl::Status Sync();
  // Cuts off what is behind `bytes`.
  absl::Status Truncate(uint64_t bytes);

  // DataLoss when the checksum is wrong.
  absl::StatusOr<std::string> Read(const SpooledScan& scan) const;

 private:
  SpoolSegment(std::string path, int file, const DiskCalls& disk)
      : path_(std::move(path)), file_(file), disk_(disk) {}

  absl::Status WriteAll(const std::string& bytes, uint64_t offset);
  absl::Status ReadHeader();
  absl::StatusOr<uint64_t> FileBytes() const;
  // True if a record begins there; of a file of `size` bytes.
  bool RecordAt(uint64_t offset, uint64_t size, bool verify, SpooledScan* scan) const;
  // Where the next one that can be read begins; `size` if there is none.
  uint64_t NextRecord(uint64_t from, uint64_t size, bool verify) const;

  const std::string path_;
  const int file_;
  const DiskCalls& disk_;
  SegmentHeader header_;
  uint64_t header_bytes_ = 0;
  uint64_t bytes_ = 0;  // Behind the last scan.
};

// Makes a new or removed name in the folder survive a power cut.
absl::Status SyncFolder(const std::string& folder);

}  // namespace isthmus::client
