// The upload of clouds with poses as a robot's submaps.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "client/cloud_upload/cloud_poses.h"
#include "client/cloud_upload/submap_cutter.h"
#include "client/console/recording_options.h"
#include "client/library/client.h"

namespace isthmus::cli {

struct UploadOptions {
  std::string path, robot;
  std::string poses;    // File of poses; empty: the clouds' own VIEWPOINT.
  std::string session;  // To go on in; empty: the one that the same upload began, else a new one.
  RecordingOptions recording;
  cloud_upload::CutOptions cut;
  cloud_upload::AssociationOptions association;
  bool poses_of_base = false;  // Poses are T_odom_base, by the recording's static transforms.
  bool finish = true;
};

// A recording, and what tells its clouds' poses.
struct PosedClouds {
  RobotScans scans;
  // Absent: their viewpoints. Shared with the reader of several LiDARs.
  std::shared_ptr<const cloud_upload::CloudPoses> poses;
  Pose T_posed_sensor;  // Posed: the frame of the poses.
  // Poses and viewpoints, and points in their frame; see PoseFile.
  Eigen::Vector3d moved_by = Eigen::Vector3d::Zero();
};

// Several topics are the LiDARs of one robot, the first the leading one (JoinedClouds). What is
// assumed goes to stderr, a line each. Errors as those of OpenRobots, ReadPoses and CloudPoses;
// InvalidArgument for clouds without VIEWPOINT and no poses, and for several topics, or poses of
// the base, where nothing tells how the LiDARs are mounted or clouds have no stamps.
absl::StatusOr<PosedClouds> OpenPosedClouds(const UploadOptions& options);

struct UploadSummary {
  std::string robot, sensor;
  SessionId session;  // Empty where there was nothing to upload.
  uint64_t clouds = 0, without_pose = 0, unreadable = 0, without_points = 0;
  uint64_t keyframes = 0, points = 0;
  uint64_t submaps = 0;  // In all; of them `before` were at the server already.
  uint64_t before = 0;
  double travelled_m = 0;
  double seconds = 0;         // Wall time.
  bool was_finished = false;  // The session, before.
  bool is_finished = false;
  bool is_interrupted = false;
  // Why the clouds cannot be used, where that showed only as they were read.
  absl::Status input;
};

// Reads the clouds and uploads their submaps, one at a time; the session is opened, or found, when
// the first is complete. What the server has is not sent again. A cloud that cannot be read is
// named on stderr and left out. Once `stopped` is true nothing more is read, what is unfinished is
// dropped, and the session stays open. AlreadyExists where the server has other submaps under the
// same indices, or the session is finished and lacks some; else the server's errors.
absl::StatusOr<UploadSummary> UploadClouds(client::Client& client, PosedClouds clouds,
                                           const UploadOptions& options,
                                           const std::function<bool()>& stopped);

}  // namespace isthmus::cli
