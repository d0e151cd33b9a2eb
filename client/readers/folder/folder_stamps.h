// The stamps of a folder's scans.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>
#include <vector>

#include "client/readers/folder/scan_files.h"

namespace isthmus::readers {

struct FolderStamps {
  std::vector<int64_t> stamps_ns;  // One for each file.
  // Names of files are stamps as drivers give them, which may be of the start of scans: times of
  // points tell. All others are those of the END.
  bool are_of_drivers = false;
  bool only_count = false;  // Nothing stamps the scans.
  // "stamps are those of times.txt", and what else is assumed for them: see ScanReader.
  std::vector<std::string> origin;
};

// The first source that exists of: times.txt in the folder or beside it (END of each scan); KITTI's
// timestamps_end.txt; its timestamps.txt, of the instant at which the sensor faced forwards, half a
// turn before the END; names that are times (name_times.h); i / `rate_hz` seconds, where i counts
// the scans that are missing from a steady series too. A file of times with one for each of these
// numbers, missing scans included, has the i-th for scan i. One that belongs to a trajectory
// (KITTI's rows in the same folder, as many) and does not fit the scans is not theirs.
// InvalidArgument for another file of times with another number of lines than there are scans, a
// line that is no number, or a rate that is not positive.
absl::StatusOr<FolderStamps> StampsOf(const ScanFiles& files, double rate_hz);

}  // namespace isthmus::readers
