// The merged map and the robots' ways as an MCAP file for Foxglove.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "client/exports/cloud_files.h"

namespace isthmus::exports {

// Schemas of Foxglove, encoded as protobuf. Frame `map`; stamps are the scans'. /map is the cloud
// as of the first scan (foxglove.PointCloud; beyond kCloudPoints points go on in /map/2, /map/3,
// ...). Each robot of the region has /ROBOT/path (foxglove.PosesInFrame, its whole way, as of its
// first scan), /ROBOT/pose (foxglove.PoseInFrame, scan by scan), and in /tf its sensor's frame,
// called as the robot is (foxglove.FrameTransform, map to ROBOT). Messages are in order of time.
// Errors of the client and of files; PATH may be a stream.
absl::StatusOr<CloudSummary> WriteMcap(client::Client& client, const RegionQuery& query,
                                       const std::string& path, const CloudProgress& progress);

}  // namespace isthmus::exports
