#include "client/offline/merge/merged_files.h"

#include <absl/status/statusor.h>
#include <absl/strings/str_cat.h>

#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "client/console/output_name.h"
#include "client/console/region_reader.h"
#include "client/evaluation/picture.h"
#include "core/formats/tum.h"
#include "core/io/file_io.h"
#include "core/io/output_file.h"

namespace isthmus::cli {
namespace {

constexpr uint32_t kMerged = 0;  // The largest map.

struct Way {
  MergeInput* drive;
  RobotTrajectory trajectory;
};

// The session that each robot opened last.
absl::StatusOr<std::map<RobotId, SessionId>> ReadSessions(client::Client& client) {
  const auto sessions = client.ListSessions();
  if (!sessions.ok()) return sessions.status();
  std::map<RobotId, SessionId> opened;
  for (const SessionStatus& session : *sessions) {
    opened[session.record.robot] = session.record.opened();
  }
  return opened;
}

// The ways of the drives in the merged map.
absl::StatusOr<std::vector<Way>> ReadWays(client::Client& client, std::vector<MergeInput>& inputs) {
  const auto sessions = ReadSessions(client);
  if (!sessions.ok()) return sessions.status();
  std::vector<Way> ways;
  for (MergeInput& input : inputs) {
    const auto session = sessions->find(RobotId(input.robot));
    if (!input.is_drive || session == sessions->end()) continue;
    // By its session: the files drive.bag and drive-1.bag name a robot as the other's session.
    auto trajectory = client.GetTrajectory(RobotId(session->second.value()), TrajectoryFrame::kMap);
    if (absl::IsFailedPrecondition(trajectory.status())) continue;  // Too short for a submap.
    if (!trajectory.ok()) return trajectory.status();
    if (trajectory->component == kMerged) ways.push_back({&input, *std::move(trajectory)});
  }
  return ways;
}

absl::Status WriteTrajectories(const std::string& folder, const std::vector<Way>& ways) {
  for (const Way& way : ways) {
    const std::filesystem::path file = std::filesystem::path(folder) / (way.drive->robot + ".tum");
    const absl::Status written =
        io::WriteOutput(file.string(), formats::FormatTum(way.trajectory.poses));
    if (!written.ok()) return written;
    way.drive->trajectory = {file.string(), way.trajectory.poses.size(), way.trajectory.left_out};
  }
  return absl::OkStatus();
}

absl::Status WriteMapPicture(client::Client& client, const std::string& file,
                             const std::vector<Way>& ways) {
  const auto region = ReadRegion(client, {.component = kMerged});
  if (!region.ok()) return region.status();
  std::vector<std::string> names;
  std::vector<Trajectory> trajectories;  // One per robot, empty for finished maps.
  for (const RobotId& robot : region->robots) {
    names.push_back(robot.value());
    Trajectory& poses = trajectories.emplace_back();
    for (const Way& way : ways) {
      if (way.drive->robot == robot.value()) poses = way.trajectory.poses;
    }
  }
  return evaluation::WritePicture(file, region->points, trajectories, names,
                                  {.caption = "x and y in m"}, /*world_file=*/true);
}

}  // namespace

absl::Status PrepareFiles(const MergedFiles& files) {
  for (const std::string& file : {files.map, files.picture}) {
    if (file.empty()) continue;
    if (absl::Status usable = io::CheckOutput(file); !usable.ok()) return usable;
  }
  if (files.trajectories.empty()) return absl::OkStatus();
  std::error_code failed;
  std::filesystem::create_directories(files.trajectories, failed);
  if (failed) return io::FileError("create folder", files.trajectories, failed.value());
  return io::CheckOutput((std::filesystem::path(files.trajectories) / "robot.tum").string());
}

absl::Status WriteFiles(client::Client& client, const MergedFiles& files,
                        std::vector<MergeInput>& inputs) {
  ExportRequest request{.component = kMerged};
  if (OutputExtension(files.map) == ".ply") request.format = ExportFormat::kPly;
  const auto exported = client.ExportToFile(request, files.map);
  if (!exported.ok()) return exported.status();
  const auto ways = ReadWays(client, inputs);
  if (!ways.ok()) return ways.status();
  absl::Status written;
  if (!files.trajectories.empty()) written = WriteTrajectories(files.trajectories, *ways);
  if (!written.ok() || files.picture.empty()) return written;
  return WriteMapPicture(client, files.picture, *ways);
}

}  // namespace isthmus::cli
