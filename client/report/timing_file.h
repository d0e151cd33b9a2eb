// Times of an odometry's stages, scan by scan, as `isthmus odometry --timing` writes them.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

namespace isthmus::report {

struct StageColumn {
  std::string name;        // The column's, without "_ms".
  std::vector<double> ms;  // One per scan.
};

struct TimingFile {
  std::string name;                   // The file's, without folder and ending.
  std::vector<double> scans;          // Numbers of the scans.
  std::vector<StageColumn> stages;    // All columns that end in _ms, but total_ms.
  std::vector<double> total_ms;       // One per scan; the sum of the stages if there is none.
  std::vector<std::string> tracking;  // "ok", "degenerate" or "lost"; empty where it is not told.
};

// InvalidArgument, naming the line, where it is not such a file, or has no row.
absl::StatusOr<TimingFile> ReadTimingFile(const std::string& path);

}  // namespace isthmus::report
