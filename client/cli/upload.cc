// isthmus upload: robots with a SLAM of their own become robots of the server.
#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <string>

#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/interruption.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/say.h"
#include "client/console/upload_clouds.h"

namespace isthmus::cli {
namespace {

struct UploadArguments {
  ServerOptions server{.attempts = kPatientAttempts};
  UploadOptions upload;
  double max_difference_s = 1e-9 * static_cast<double>(cloud_upload::kNearestPoseNs);
  std::string clouds_in = "sensor", poses_of = "sensor";
  bool json = false;
};

Json UploadJson(const UploadSummary& summary) {
  return {{"session", summary.session.value()},
          {"robot", summary.robot},
          {"sensor", summary.sensor},
          {"clouds", summary.clouds},
          {"without_pose", summary.without_pose},
          {"unreadable", summary.unreadable},
          {"without_points", summary.without_points},
          {"keyframes", summary.keyframes},
          {"points", summary.points},
          {"submaps", summary.submaps},
          {"before", summary.before},
          {"travelled_m", summary.travelled_m},
          {"seconds", summary.seconds},
          {"finished", summary.is_finished},
          {"interrupted", summary.is_interrupted}};
}

void PrintUpload(const UploadSummary& summary) {
  Say("%s: %d submaps of %d clouds: %d keyframes, %d points, %.1f m; %d uploaded, %d were "
      "there; left out: %d without a pose, %d unreadable, %d without points; %.1f s\n",
      summary.session.empty() ? summary.robot : summary.session.value(), summary.submaps,
      summary.clouds, summary.keyframes, summary.points, summary.travelled_m,
      summary.submaps - summary.before, summary.before, summary.without_pose, summary.unreadable,
      summary.without_points, summary.seconds);
}

int ReportUpload(const UploadSummary& summary, const UploadArguments& options) {
  if (options.json) {
    Print(UploadJson(summary));
  } else {
    PrintUpload(summary);
  }
  if (!summary.input.ok()) return FailInput(summary.input);
  if (summary.is_interrupted) {
    Warn("isthmus: %s: interrupted; the same command continues\n", summary.robot);
    return kInterrupted;
  }
  if (summary.was_finished) {
    Warn("isthmus: nothing left to upload: session %s has everything and is finished\n",
         summary.session.value());
  }
  return kOk;
}

int RunUpload(UploadArguments options) {
  options.upload.association.nearest_ns =
      static_cast<int64_t>(std::llround(1e9 * options.max_difference_s));
  options.upload.poses_of_base = options.poses_of == "base";
  if (options.clouds_in == "odom") options.upload.cut.frame = cloud_upload::CloudFrame::kOdom;
  if (absl::Status status = CheckOptions(options.upload.cut); !status.ok()) {
    return Fail(kUsage, status);
  }
  std::atomic<bool> has_begun = false, is_stopped = false;
  const Interruption interruption([&] {
    is_stopped = true;
    if (!has_begun) _exit(kInterrupted);
    Warn(
        "\nisthmus: interrupted: finishing the submap that is being sent; press Ctrl-C again to "
        "end at once\n");
  });
  auto clouds = OpenPosedClouds(options.upload);
  if (!clouds.ok()) return FailInput(clouds.status());
  const auto client = ConnectPatiently(options.server);
  if (!client.ok()) return FailServer(client.status());
  has_begun = true;
  const auto summary = UploadClouds(**client, *std::move(clouds), options.upload,
                                    [&is_stopped] { return is_stopped.load(); });
  return summary.ok() ? ReportUpload(*summary, options) : FailServer(summary.status());
}

void AddCutOptions(CLI::App& command, UploadArguments& options) {
  command
      .add_option("--clouds-in", options.clouds_in,
                  "Frame of the points: sensor, or odom, the frame of the trajectory")
      ->check(CLI::IsMember({"sensor", "odom"}))
      ->capture_default_str();
  command
      .add_option("--poses-of", options.poses_of,
                  "Whose poses: sensor, the sensor of the clouds, or base, the robot's base_link "
                  "by tf_static")
      ->check(CLI::IsMember({"sensor", "base"}))
      ->capture_default_str();
  cloud_upload::CutOptions& cut = options.upload.cut;
  command
      .add_option("--voxel", cut.voxel_m,
                  "Thin: one point per voxel of this size (m) and keyframe; 0: all points")
      ->capture_default_str();
  command
      .add_option("--max-range", cut.range_m,
                  "Leave out points farther from the sensor than this (m)")
      ->capture_default_str();
}

}  // namespace

void AddUpload(CLI::App& app, Action& action) {
  auto options = std::make_shared<UploadArguments>();
  CLI::App* command = app.add_subcommand(
      "upload", "Upload clouds with the poses of a robot's own SLAM, as a robot");
  AddServerOptions(*command, options->server);
  UploadOptions& upload = options->upload;
  command
      ->add_option("PATH", upload.path,
                   "Folder of clouds, one per scan or keyframe, or any recording that `isthmus "
                   "info` reads")
      ->required();
  command->add_option("--robot", upload.robot, "Name of the robot")->required();
  command->add_option("--poses", upload.poses,
                      "Poses of the sensor: TUM (stamp tx ty tz qx qy qz qw), KITTI (12 numbers a "
                      "line) or g2o (VERTEX_SE3:QUAT in order of ids; its edges are not used). "
                      "Without it the VIEWPOINT of .pcd files");
  command
      ->add_option("--max-difference", options->max_difference_s,
                   "Greatest difference between the stamps of a cloud and its pose (s), if the "
                   "cloud does not lie between two poses at most 0.5 s apart")
      ->check(Between(0.0, 1e6))
      ->capture_default_str();
  AddCutOptions(*command, *options);
  AddRecordingOptions(*command, upload.recording);
  command->add_option(
      "--session", upload.session,
      "Continue this session. Without it the same command continues where it was interrupted");
  command->add_flag("--finish,!--no-finish", upload.finish,
                    "Finish the session at the end (default)");
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return RunUpload(*options); }; });
}

}  // namespace isthmus::cli
