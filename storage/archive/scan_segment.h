// One file of an archive of scans: a head, then records one after the other.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/append_file.h"
#include "core/scan_upload.h"
#include "storage/archive/scan_record.h"

namespace isthmus::storage {

inline constexpr uint64_t kSegmentHeadSize = 16;

// The bytes every segment starts with.
std::string MakeSegmentHead();

// "000042.scans".
std::string SegmentName(int number);
// The segments of a folder in order; empty where there is no folder.
std::vector<int> ListSegments(const std::string& folder);

// The place of a record.
struct ScanPlace {
  uint64_t offset = 0;
  ScanHeader header;
};

// Bytes that are no record.
struct DamagedBytes {
  uint64_t offset = 0, size = 0;
};

struct SegmentIndex {
  std::vector<ScanPlace> scans;       // In the order in which they lie there.
  std::vector<DamagedBytes> damaged;  // Before the end.
  uint64_t end = 0;                   // Of the last record; what is behind it was not finished.
};

enum class Look {
  kHeaders,  // A body may be damaged.
  kBodies,   // Every record is whole.
};

// Finds the records of a segment, those behind damaged ones too. FailedPrecondition for a file that
// a newer program made.
absl::StatusOr<SegmentIndex> IndexSegment(const io::AppendFile& file, Look look);

}  // namespace isthmus::storage
