#include "lab/bench/moving/mapped_drive.h"

#include <absl/strings/str_cat.h>

#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/submap_builder.h"

namespace isthmus::bench {

absl::StatusOr<MappedDrive> MapDrive(const DriveOptions& options, const std::string& name) {
  const auto grounded = SimulateDrive(options);
  if (!grounded.ok()) return grounded.status();
  const Drive& drive = grounded->drive;
  const auto sensor = floam::FindSensorModel(drive.sensor);
  if (!sensor.ok()) return sensor.status();
  floam::Odometry odometry(*sensor, {});
  floam::SubmapBuilder builder(SessionId(name + "-1"), RobotId(name), {});
  MappedDrive mapped;
  const auto add = [&](const std::shared_ptr<const Submap>& submap) {
    if (submap == nullptr) return;
    odometry.Remember(*submap);
    // Scans are numbered from 1, turns from 0.
    const auto first = static_cast<int>(submap->keyframes.front().sequence) - 1;
    mapped.submaps.push_back(submap);
    mapped.T_world_submap.push_back(drive.truth_of(first));
  };
  for (size_t i = 0; i < drive.shots.size(); ++i) {
    const auto result = odometry.Process(MakeScan(drive, drive.shots[i], i + 1));
    if (!result.ok()) continue;
    if (result->segment > 1) break;
    add(builder.Add(*result));
  }
  add(builder.Finish());
  return mapped;
}

absl::StatusOr<MappedTeam> MapTeam(DriveOptions options) {
  MappedTeam team;
  for (options.robot = 0; options.robot < options.robots; ++options.robot) {
    auto mapped = MapDrive(options, absl::StrCat("robot_", options.robot));
    if (!mapped.ok()) return mapped.status();
    for (size_t i = 0; i < mapped->submaps.size(); ++i) {
      const std::shared_ptr<const Submap>& submap = mapped->submaps[i];
      team.placed.push_back(
          {std::make_shared<SubmapInfo>(Summarize(*submap)), 0, mapped->T_world_submap[i]});
      team.content[submap->id] = submap;
    }
  }
  return team;
}

}  // namespace isthmus::bench
