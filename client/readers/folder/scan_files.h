// The files of a folder that are scans.
#pragma once

#include <absl/status/statusor.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/folder/name_series.h"
#include "client/readers/folder/name_times.h"

namespace isthmus::readers {

struct ScanFiles {
  std::filesystem::path folder;              // They lie in.
  std::vector<std::filesystem::path> files;  // In order.
  std::string extension;                     // ".bin", of all of them; lower case.
  bool is_one_file = false;                  // Named itself, whatever else is in the folder.
  std::optional<NameTimes> times;            // Told by their names.
  NameSeries series;                         // Made by their names.
  std::vector<std::string> left_out;         // Names that do not fit the series.
};

// The file itself, if it is a scan; for a folder, the scans in it, else those of the folder in it
// where they usually are (KITTI's velodyne_points/data and velodyne, scans). Files of one series
// (name_series.h) are the scans, in the order of their times (name_times.h), else in the series'
// order. Text files are scans if nothing else is and their names begin with a number (.txt) or they
// are called .csv, .xyz, .asc or .pts. NotFound for a path that does not exist or holds no scans;
// InvalidArgument for a mixture of formats.
absl::StatusOr<ScanFiles> FindScans(const std::string& path);

// The folder by its whole name, without a separator at the end.
std::filesystem::path WholeName(const std::filesystem::path& folder);

// The file of that name in the folder, else beside it.
std::optional<std::filesystem::path> FindBeside(const std::filesystem::path& folder,
                                                const char* name);

}  // namespace isthmus::readers
