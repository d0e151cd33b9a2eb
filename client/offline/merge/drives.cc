#include "client/offline/merge/drives.h"

#include <absl/strings/str_cat.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "core/formats/cloud_file.h"

namespace isthmus::cli {

bool IsDrive(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_directory(path, error) ||
         !formats::IsCloudFile(std::filesystem::path(path).extension());
}

absl::StatusOr<Drives> OpenDrives(const std::vector<std::string>& paths,
                                  const RecordingOptions& options, std::set<std::string>& names) {
  Drives drives;
  for (const std::string& path : paths) {
    absl::StatusOr<std::vector<RobotScans>> robots = OpenRobots(path, options);
    if (!robots.ok()) return robots.status();
    for (RobotScans& robot : *robots) {
      const std::string wanted = !robot.robot.empty() ? robot.robot
                                 : robots->size() > 1 ? robot.topic
                                                      : path;
      robot.robot = UniqueRobotName(wanted, names);
      MergeInput input;
      input.file = robot.topic.empty() ? path : absl::StrCat(path, " ", robot.topic);
      input.robot = robot.robot;
      drives.inputs.push_back(std::move(input));
      drives.robots.push_back(std::move(robot));
    }
  }
  return drives;
}

absl::Status PushDrives(client::Client& client, Drives& drives, PushControl& control) {
  if (drives.robots.empty()) return absl::OkStatus();
  const auto summaries = PushRobots(client, std::move(drives.robots), {.resolution_m = 0}, control);
  if (!summaries.ok()) return summaries.status();
  for (size_t i = 0; i < summaries->size(); ++i) {
    const PushSummary& summary = (*summaries)[i];
    drives.inputs[i].viewpoints = summary.scans.processed;
    drives.inputs[i].is_drive = true;
    if (summary.is_interrupted) return absl::CancelledError("interrupted");
    if (summary.scans.processed > 0) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        drives.inputs[i].file, ": none of its scans could be used: ", summary.first_rejection));
  }
  return absl::OkStatus();
}

}  // namespace isthmus::cli
