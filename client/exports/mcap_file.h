// The merged map and the robots' ways as an MCAP file for Foxglove.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "client/exports/cloud_files.h"

namespace isthmus::exports {

// Schemas of Foxglove, encoded as protobuf. Frame `map`; stamps are the scans'. /map is the cloud
// as of the first scan (foxglove.PointCloud; beyond kCloudPoints points go on in /map/2, /map/3,
// ...). Each session of the region's robots has /SESSION/path (foxglove.PosesInFrame, its whole
// way, as of the first scan), /SESSION/pose (foxglove.PoseInFrame, scan by scan), and in /tf its
// robot's sensor, called as the robot is (foxglove.FrameTransform, map to ROBOT). Messages are in
// order of time. Errors of the client and of files; PATH may be a stream.
absl::StatusOr<CloudSummary> WriteMcap(client::Client& client, const RegionQuery& query,
                                       const std::string& path, const CloudProgress& progress);

}  // namespace isthmus::exports
