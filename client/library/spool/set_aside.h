// The scans of a spool that no server takes, kept beside it.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

namespace isthmus::client {

// All files of a spool's scans that were set aside, bytes: some hundred scans, as no more come of
// what is a setting or two. More would fill a robot's disk.
inline constexpr uint64_t kMaxSetAsideBytes = uint64_t{1} << 30;

// Writes the scan, a ScanMessage in bytes, to SPOOL/too-large/STAMP.scan, where it is on the disk
// on return; returns that path. The same scan again replaces its file. ResourceExhausted where
// `most_bytes` are there already; else io::FileError's.
absl::StatusOr<std::string> SetAside(const std::string& spool, int64_t stamp_ns,
                                     const std::string& scan,
                                     uint64_t most_bytes = kMaxSetAsideBytes);

}  // namespace isthmus::client
