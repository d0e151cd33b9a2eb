#include "client/console/scan_options.h"

#include <CLI/Error.hpp>

#include "client/console/exit_code.h"

namespace isthmus::cli {

void AddScanOptions(CLI::App& command, ScanOptions& options) {
  command
      .add_option("PATH", options.path,
                  "Folder of KITTI .bin or .pcd scans; times.txt in it or beside it gives the "
                  "stamps (END of each scan)")
      ->required();
  command.add_option("--from", options.from, "First scan of the folder, counted from 0")
      ->capture_default_str();
  command.add_option("--to", options.to, "Last scan of the folder, included");
}

void AddOdometryMode(CLI::App& command, std::optional<OdometryMode>& mode) {
  const auto parse = [&mode](const std::string& name) {
    const absl::StatusOr<OdometryMode> parsed = ParseOdometryMode(name);
    if (!parsed.ok()) {
      throw CLI::ValidationError("--odometry", std::string(parsed.status().message()));
    }
    mode = *parsed;
  };
  command.add_option_function<std::string>(
      "--odometry", parse,
      "continuous (the best), floam (the paper's two stages) or aloam (to compare with); without "
      "it the server's own choice");
}

std::optional<readers::ScanFolder> OpenScans(const ScanOptions& options, std::string& sensor,
                                             int& code) {
  auto folder = readers::ScanFolder::Open(
      options.path, {.rate_hz = options.rate_hz, .from = options.from, .to = options.to});
  if (!folder.ok()) {
    code = FailInput(folder.status());
    return std::nullopt;
  }
  if (sensor.empty()) {
    absl::StatusOr<std::string> guess = folder->GuessSensor();
    if (!guess.ok()) {
      code = FailInput(guess.status());
      return std::nullopt;
    }
    sensor = *guess;
  }
  return *std::move(folder);
}

}  // namespace isthmus::cli
