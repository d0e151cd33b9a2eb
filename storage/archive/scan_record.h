// One scan as it lies in an archive of scans. The byte layout is specified in
// docs/storage-format.md, "The archive of scans".
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "core/scan_upload.h"

namespace isthmus::storage {

inline constexpr size_t kScanHeaderSize = 32;
inline constexpr char kScanMagic[] = "scan";  // Every record starts with these four.
inline constexpr size_t kScanMagicSize = 4;
// Larger ones cannot come through the network (network.max_receive_bytes).
inline constexpr uint32_t kMaxScanBody = 1u << 30;

struct ScanHeader {
  uint32_t body_size = 0;
  uint64_t sequence = 0;
  int64_t end_stamp_ns = 0;
  uint32_t body_crc = 0;
};

// Header and body. The payload is kept bit by bit, whatever it holds: scans that the odometry
// rejected are kept too. InvalidArgument for one that is larger than any scan may be.
absl::StatusOr<std::string> EncodeScanRecord(const ScanUpload& scan);

// The header in the first kScanHeaderSize bytes; absent when they are no header, or a damaged one.
std::optional<ScanHeader> DecodeScanHeader(const std::string& bytes);

bool IsWhole(const ScanHeader& header, const std::string& body);

// DataLoss for a body that is damaged.
absl::StatusOr<ScanUpload> DecodeScanBody(const ScanHeader& header, const std::string& body);

}  // namespace isthmus::storage
