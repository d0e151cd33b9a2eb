// One file of an archive of scans: a head, then records one after the other.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/record_log.h"

namespace isthmus::storage {

inline constexpr uint64_t kSegmentHeadSize = 16;
inline constexpr char kScanMarker[] = "scan";  // Every record starts with these four.

// The bytes every segment starts with.
std::string MakeSegmentHead();

// "000042.scans".
std::string SegmentName(int number);
// The segments of a folder in order; empty where there is no folder.
std::vector<int> ListSegments(const std::string& folder);

// The scans of a segment. FailedPrecondition for a file that a newer program made.
absl::StatusOr<io::RecordIndex> IndexSegment(const io::AppendFile& file, io::Look look);

}  // namespace isthmus::storage
