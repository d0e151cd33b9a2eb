// A crash-safe log: a file of records, each with checksums of its own, so that what a crash tore
// off and what a disk damaged cost no record but their own.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/append_file.h"

namespace isthmus::io {

inline constexpr uint64_t kRecordHeaderBytes = 32;

// The place of a record. A record is, little endian: four bytes that all records of the log begin
// with, u32 size of the body, u64 sequence, i64 stamp, u32 crc32c of the body, u32 crc32c of these
// 28 bytes, then the body.
struct Record {
  uint64_t sequence = 0;
  int64_t stamp_ns = 0;
  uint64_t offset = 0;  // Offset of the body in the file.
  uint32_t size = 0;    // Size of the body.
  uint32_t crc32c = 0;  // Checksum of the body.

  uint64_t begin() const { return offset - kRecordHeaderBytes; }
  uint64_t end() const { return offset + size; }
};

// Behind the last. On error as AppendFile::Append.
absl::StatusOr<Record> AppendRecord(AppendFile& file, const char marker[4], uint64_t sequence,
                                    int64_t stamp_ns, const std::string& body);

enum class Look {
  kHeaders,  // A body may be damaged.
  kBodies,   // Every record is whole.
};

struct DamagedBytes {
  uint64_t offset = 0, size = 0;
};

struct RecordIndex {
  std::vector<Record> records;        // In the order in which they lie there.
  std::vector<DamagedBytes> damaged;  // Bytes before the end that belong to no record.
  uint64_t end = 0;                   // The last record's end; bytes behind it were not finished.
};

// Finds the records from `begin` on, those behind damaged or unreadable bytes too. An error of the
// disk only where the bytes behind the last record cannot be read: they may be more records.
absl::StatusOr<RecordIndex> FindRecords(const AppendFile& file, const char marker[4],
                                        uint64_t begin, Look look);

// DataLoss when the body is damaged.
absl::StatusOr<std::string> ReadBody(const AppendFile& file, const Record& record);

}  // namespace isthmus::io
