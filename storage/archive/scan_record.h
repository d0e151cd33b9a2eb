// The body of a scan's record in an archive of scans. The byte layout is specified in
// docs/storage-format.md, "The archive of scans".
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "core/io/record_log.h"
#include "core/scan_upload.h"

namespace isthmus::storage {

// Keeps the scan bit by bit: scans that the odometry rejected are kept too. InvalidArgument for one
// that is larger than any scan may be.
absl::StatusOr<std::string> EncodeScan(const ScanUpload& scan);

// From a record and its body. DataLoss for a body that no encoder makes.
absl::StatusOr<ScanUpload> DecodeScan(const io::Record& record, const std::string& body);

}  // namespace isthmus::storage
