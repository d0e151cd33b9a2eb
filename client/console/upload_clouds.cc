#include "client/console/upload_clouds.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cstdio>
#include <utility>
#include <vector>

#include "client/cloud_upload/joined_clouds.h"
#include "client/console/console.h"
#include "client/console/say.h"
#include "client/console/submap_sender.h"
#include "core/geometry/near_origin.h"
#include "core/stopwatch.h"

namespace isthmus::cli {
namespace {

using cloud_upload::CloudPoses;
using cloud_upload::SubmapCutter;
using readers::RecordedScan;

bool IsIdentity(const Pose& pose) { return pose.Matrix().isIdentity(1e-9); }

// The clouds' own viewpoints, which every program writes, and most as the identity.
class Viewpoints {
 public:
  // `moved_by` is added to their translations.
  absl::StatusOr<std::optional<StampedPose>> Of(const RecordedScan& cloud,
                                                const Eigen::Vector3d& moved_by) {
    if (!cloud.viewpoint) return std::nullopt;
    const bool tells = !IsIdentity(*cloud.viewpoint);
    if (!tells && seen_ == 1 && !first_tells_) {
      return absl::InvalidArgumentError(absl::StrCat(
          cloud.name,
          " and the cloud before it have no VIEWPOINT but the identity: name their poses with "
          "--poses"));
    }
    if (seen_++ == 0) first_tells_ = tells;
    return StampedPose{cloud.end_stamp_ns, Pose(moved_by) * *cloud.viewpoint};
  }

 private:
  size_t seen_ = 0;
  bool first_tells_ = false;
};

void SayShift(const std::string& file, const Eigen::Vector3d& shift) {
  if (shift.isZero()) return;
  Warn("isthmus: %s\n", ShiftText(file, shift));
}

void NameLeftOut(const std::string& name, const absl::Status& why, UploadSummary& summary) {
  ++summary.unreadable;
  Warn("isthmus: left out %s%s%s\n", name, name.empty() ? "" : ": ", std::string(why.message()));
}

cloud_upload::CutOptions CutOptionsOf(const PosedClouds& clouds, const UploadOptions& options) {
  cloud_upload::CutOptions cut = options.cut;
  cut.moved_by = clouds.moved_by;
  return cut;
}

// Reads, cuts and sends.
class Uploader {
 public:
  Uploader(client::Client& client, PosedClouds& clouds, const UploadOptions& options)
      : clouds_(clouds),
        options_(options),
        cutter_(CutOptionsOf(clouds, options)),
        sender_(client, {{RobotId(options.robot), clouds.scans.sensor}, options.session}) {
    summary_.robot = options.robot;
    summary_.sensor = clouds.scans.sensor;
  }

  absl::StatusOr<UploadSummary> Run(const std::function<bool()>& stopped) {
    const Stopwatch watch;
    Progress progress(options_.robot, clouds_.scans.reader->size().value_or(0));
    while (!stopped() && summary_.input.ok()) {
      absl::StatusOr<std::optional<RecordedScan>> cloud = clouds_.scans.reader->Next();
      if (cloud.ok() && !cloud->has_value()) break;
      if (absl::Status status = Take(cloud); !status.ok()) return status;
      progress.Update(++summary_.clouds);
    }
    summary_.is_interrupted = stopped();
    if (!summary_.is_interrupted && summary_.input.ok()) {
      if (std::optional<SubmapUpload> last = cutter_.Finish()) {
        if (absl::Status status = sender_.Send(*std::move(last)); !status.ok()) return status;
      }
      if (options_.finish) {
        if (absl::Status status = sender_.Finish(); !status.ok()) return status;
        summary_.is_finished = !sender_.session().empty();
      }
    }
    Count();
    summary_.seconds = watch.Ms() / 1000;
    return std::move(summary_);
  }

 private:
  absl::Status Take(const absl::StatusOr<std::optional<RecordedScan>>& read) {
    if (!read.ok()) {
      NameLeftOut("", read.status(), summary_);
      return absl::OkStatus();
    }
    const RecordedScan& cloud = **read;
    const auto pose = PoseOf(cloud);
    if (!pose.ok()) {
      summary_.input = pose.status();
      return absl::OkStatus();
    }
    if (!pose->has_value()) {
      ++summary_.without_pose;
      NoteWithoutPose(cloud.end_stamp_ns);
      return absl::OkStatus();
    }
    absl::StatusOr<std::vector<SubmapUpload>> submaps = cutter_.Add(**pose, cloud.payload);
    if (!submaps.ok()) {
      NameLeftOut(cloud.name, submaps.status(), summary_);
      return absl::OkStatus();
    }
    for (SubmapUpload& submap : *submaps) {
      if (absl::Status status = sender_.Send(std::move(submap)); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::StatusOr<std::optional<StampedPose>> PoseOf(const RecordedScan& cloud) {
    if (!clouds_.poses) return viewpoints_.Of(cloud, clouds_.moved_by);
    auto pose =
        clouds_.poses->Of(options_.recording.read.from + summary_.clouds, cloud.end_stamp_ns);
    if (pose) pose->pose = pose->pose * clouds_.T_posed_sensor;
    return pose;
  }

  void NoteWithoutPose(int64_t stamp_ns) {
    if (summary_.without_pose == 1) first_without_ns_ = stamp_ns;
    last_without_ns_ = stamp_ns;
  }

  void Count() {
    summary_.session = sender_.session();
    summary_.was_finished = sender_.was_finished();
    summary_.is_finished = summary_.is_finished || summary_.was_finished;
    summary_.submaps = sender_.submaps();
    summary_.before = sender_.before();
    summary_.keyframes = cutter_.keyframes();
    summary_.points = cutter_.points();
    summary_.without_points = cutter_.without_points();
    summary_.travelled_m = cutter_.travelled_m();
    if (!summary_.input.ok() || summary_.is_interrupted || summary_.keyframes > 0) return;
    std::string why = absl::StrCat("none of the ", summary_.clouds, " clouds could be used");
    if (summary_.without_pose > 0 && clouds_.poses && !clouds_.poses->in_order()) {
      const Trajectory& poses = clouds_.poses->poses();
      absl::StrAppendFormat(&why,
                            ": clouds without a pose are from %.3f to %.3f s, poses from %.3f to "
                            "%.3f s; see --max-difference",
                            1e-9 * static_cast<double>(first_without_ns_),
                            1e-9 * static_cast<double>(last_without_ns_),
                            1e-9 * static_cast<double>(poses.front().stamp_ns),
                            1e-9 * static_cast<double>(poses.back().stamp_ns));
    } else if (summary_.without_points > 0) {
      absl::StrAppend(&why,
                      ": they have no points within --max-range of the sensor; see "
                      "--clouds-in");
    }
    summary_.input = absl::InvalidArgumentError(why);
  }

  PosedClouds& clouds_;
  const UploadOptions& options_;
  UploadSummary summary_;
  SubmapCutter cutter_;
  SubmapSender sender_;
  Viewpoints viewpoints_;
  int64_t first_without_ns_ = 0, last_without_ns_ = 0;
};

// Places the leading sensor in the frame of the poses.
absl::Status PlaceSensor(const UploadOptions& options, const std::vector<RobotScans>& robots,
                         PosedClouds& clouds) {
  if (robots.size() == 1 && !options.poses_of_base) return absl::OkStatus();
  const auto is_mounted = [](const RobotScans& lidar) { return lidar.T_base_sensor.has_value(); };
  if (!is_mounted(clouds.scans) || !std::all_of(robots.begin() + 1, robots.end(), is_mounted)) {
    return absl::InvalidArgumentError(absl::StrCat(
        options.path,
        " does not tell how the LiDARs are mounted: it needs tf_static from base_link (or "
        "base_footprint) to the frames of all clouds"));
  }
  if (options.poses_of_base) clouds.T_posed_sensor = *clouds.scans.T_base_sensor;
  return absl::OkStatus();
}

// One reader for all. `robots[0]` is in `clouds` already.
absl::StatusOr<PosedClouds> JoinLidars(const UploadOptions& options, std::vector<RobotScans> robots,
                                       PosedClouds clouds) {
  if (robots.size() == 1) return clouds;
  if (clouds.poses->in_order() || options.cut.frame == cloud_upload::CloudFrame::kOdom) {
    return absl::InvalidArgumentError(
        "several LiDARs are joined by their stamps, in the frames of their sensors: poses need "
        "stamps, and --clouds-in odom takes one topic");
  }
  std::vector<cloud_upload::MountedClouds> others;
  const Pose T_leading_base = clouds.scans.T_base_sensor->Inverse();
  for (size_t i = 1; i < robots.size(); ++i) {
    others.push_back({std::move(robots[i].reader), T_leading_base * *robots[i].T_base_sensor});
  }
  const auto motion = [poses = clouds.poses, T = clouds.T_posed_sensor](
                          int64_t to_ns, int64_t from_ns) -> std::optional<Pose> {
    const auto to = poses->Of(0, to_ns), from = poses->Of(0, from_ns);
    if (!to || !from) return std::nullopt;
    return (to->pose * T).Inverse() * (from->pose * T);
  };
  clouds.scans.reader =
      std::make_unique<readers::StartedReader>(std::make_unique<cloud_upload::JoinedClouds>(
          std::move(clouds.scans.reader), std::move(others), motion));
  return clouds;
}

}  // namespace

absl::StatusOr<PosedClouds> OpenPosedClouds(const UploadOptions& options) {
  absl::StatusOr<std::vector<RobotScans>> robots = OpenRobots(options.path, options.recording);
  if (!robots.ok()) return robots.status();
  PosedClouds clouds;
  clouds.scans = std::move(robots->front());
  const readers::StartedReader& reader = *clouds.scans.reader;
  if (options.poses.empty()) {
    if (reader.first() != nullptr && !reader.first()->viewpoint) {
      return absl::InvalidArgumentError(absl::StrCat(
          options.path, " has no poses for its clouds: give a file of poses with --poses"));
    }
    if (robots->size() > 1 || options.poses_of_base) {
      return absl::InvalidArgumentError("several LiDARs, and poses of the base, need --poses");
    }
    if (reader.first() != nullptr) {
      clouds.moved_by = ShiftToOrigin(reader.first()->viewpoint->translation());
      SayShift(options.path, clouds.moved_by);
    }
    return clouds;
  }
  if (absl::Status status = PlaceSensor(options, *robots, clouds); !status.ok()) return status;
  absl::StatusOr<cloud_upload::PoseFile> file = cloud_upload::ReadPoses(options.poses);
  if (!file.ok()) return file.status();
  clouds.moved_by = file->moved_by;
  SayShift(options.poses, clouds.moved_by);
  const cloud_upload::CloudSeries series{reader.has_stamps(), options.recording.read.from,
                                         reader.size(), options.recording.read.to.has_value()};
  absl::StatusOr<CloudPoses> poses =
      CloudPoses::Create(*std::move(file), series, options.association);
  if (!poses.ok()) {
    return absl::Status(poses.status().code(),
                        absl::StrCat(options.poses, ": ", poses.status().message()));
  }
  if (poses->in_order()) {
    Warn("isthmus: %s: clouds and poses are paired in order%s\n", options.path,
         reader.has_stamps() ? "" : ": the clouds have no times");
  }
  clouds.poses = std::make_shared<const CloudPoses>(*std::move(poses));
  return JoinLidars(options, *std::move(robots), std::move(clouds));
}

absl::StatusOr<UploadSummary> UploadClouds(client::Client& client, PosedClouds clouds,
                                           const UploadOptions& options,
                                           const std::function<bool()>& stopped) {
  return Uploader(client, clouds, options).Run(stopped);
}

}  // namespace isthmus::cli
