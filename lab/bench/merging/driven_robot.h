// One robot's drive as the server mapped it, with the truth beside it.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/map/anchor.h"
#include "core/map/loop_closure.h"
#include "core/map/session.h"
#include "core/map/submap.h"
#include "core/pose.h"
#include "lab/bench/merging/drive_options.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

// A scan that was not lost.
struct ScanPose {
  uint64_t sequence = 0;
  int64_t stamp_ns = 0;
  uint32_t submap = 0;
  Pose T_world_sensor;  // At the END of the scan.
  Pose T_odom_sensor;
};

// Value type; submaps are shared and never changed.
struct DrivenRobot {
  std::string ground;
  double overlap_cell_m = 1;
  int lost_scans = 0;
  double further_m = 0;  // See simulation::WildDrive, as the next.
  bool blocked = false;
  SessionRecord session;
  std::vector<std::shared_ptr<const Submap>> submaps;
  std::vector<ScanPose> poses;     // In order of sequence.
  std::vector<LoopClosure> loops;  // See FindOwnLoops.
  std::vector<Anchor> anchors;     // See AddAnchors.

  // Null for a scan that was lost.
  const ScanPose* FindPose(uint64_t sequence) const;
  // RMSE of its positions after rigid alignment; NaN for fewer than three.
  double OdometryRmse() const;
};

// Streams the drive through a server of its own that keeps its data in `folder`, which must exist
// and be empty, and writes the truth beside them.
absl::Status DriveThroughServer(const GroundedDrive& grounded,
                                const server::PipelineOptions& options, const std::string& folder);

// Loads what was kept in such a folder; of a drive in several segments, the longest one. The folder
// is only read: many programs may do so at a time. NotFound if it holds no drive.
absl::StatusOr<DrivenRobot> LoadDrivenRobot(const std::string& folder);

// The submaps `from` up to `to`, without it, of the robot's drive, numbered from 0.
DrivenRobot PartOf(const DrivenRobot& robot, size_t from, size_t to);

// The robot under another name: its session and submaps are called after it.
void Rename(DrivenRobot* robot, const std::string& name);

}  // namespace isthmus::bench
