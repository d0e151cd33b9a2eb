// The options PATH, --from and --to, which name scans of a folder. Shared by `push` and `odometry`.
#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "client/readers/folder/scan_folder.h"
#include "core/odometry_mode.h"

namespace isthmus::cli {

struct ScanOptions {
  std::string path;
  double rate_hz = 10;  // Of the stamps, where there is no times.txt.
  size_t from = 0;
  std::optional<size_t> to = std::nullopt;
};

void AddScanOptions(CLI::App& command, ScanOptions& options);

// --odometry: which one; stays absent, the server's own choice, unless given.
void AddOdometryMode(CLI::App& command, std::optional<OdometryMode>& mode);

// Opens the folder and, where `sensor` is empty, finds it. Empty after an error, which is on stderr
// and in `code`.
std::optional<readers::ScanFolder> OpenScans(const ScanOptions& options, std::string& sensor,
                                             int& code);

}  // namespace isthmus::cli
