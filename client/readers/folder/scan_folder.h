// A recorded drive as a folder of scans: KITTI's .bin or .pcd.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/point_payload.h"

namespace isthmus::readers {

struct ScanFolderOptions {
  double rate_hz = 10;  // Where there is no times.txt, scan i ended at i / rate_hz seconds.
  // First and last scan to take, counted from 0 in the whole folder, which keeps its stamps.
  size_t from = 0;
  std::optional<size_t> to = std::nullopt;  // Included; absent: the last one.
};

// Scans in order of the numbers in their names (of the names, where they are not numbers). Stamps
// are the END of each scan: seconds, one per line, of `times.txt` in the folder, else beside it.
// Reads a scan when it is asked for. Immutable.
class ScanFolder {
 public:
  // NotFound for a folder that does not exist or holds no scans; InvalidArgument for a mixture of
  // .bin and .pcd, a times.txt with another number of lines than there are scans, a line that is no
  // number or not later than the one before, an empty range, or a rate that is not positive.
  static absl::StatusOr<ScanFolder> Open(const std::string& path,
                                         const ScanFolderOptions& options = {});

  size_t size() const { return files_.size(); }
  const std::string& file(size_t i) const { return files_[i]; }
  int64_t stamp_ns(size_t i) const { return stamps_ns_[i]; }
  // The message names the file.
  absl::StatusOr<PointPayload> Read(size_t i) const;

  // The sensor, as far as the folder tells: "sensor" in simulation.json in it or beside it; hdl64
  // for .bin; the smallest usual model with as many rings as the first scan of a .pcd folder has.
  // NotFound, saying what to do, when nothing tells.
  absl::StatusOr<std::string> GuessSensor() const;

 private:
  bool kitti_ = false;
  std::string path_;
  std::vector<std::string> files_;
  std::vector<int64_t> stamps_ns_;
};

}  // namespace isthmus::readers
