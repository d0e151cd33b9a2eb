// isthmus trajectory: where a robot's sensor, or the robot itself, was, scan by scan.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/numbers.h"
#include "client/console/output_name.h"
#include "client/console/say.h"
#include "core/formats/kitti_poses.h"
#include "core/formats/tum.h"
#include "core/io/output_file.h"

namespace isthmus::cli {
namespace {

struct TrajectoryOptions {
  ServerOptions server;
  std::string robot, frame = "map", poses_of = "sensor", format = "tum", output;
  uint32_t segment = 0;
};

// The segments of the poses, and those left out; empty for a session with one segment.
std::string SegmentsText(const RobotTrajectory& trajectory, bool is_map) {
  if (trajectory.parts.size() + trajectory.left_out.size() < 2) return "";
  std::string text = "; segment ";
  for (size_t i = 0; i < trajectory.parts.size(); ++i) {
    absl::StrAppend(&text, i > 0 ? ", " : "", trajectory.parts[i].segment);
  }
  if (trajectory.left_out.empty()) return text;
  return absl::StrCat(text, "; not in it (",
                      is_map ? "another map, or not placed" : "another frame",
                      "; see --segment): ", absl::StrJoin(trajectory.left_out, ", "));
}

// Poses of the robot's base in place of those of its sensor.
absl::Status MoveToBase(client::Client& client, RobotTrajectory& trajectory) {
  const auto session = client.GetSession(trajectory.session);
  if (!session.ok()) return session.status();
  const Pose& T_base_sensor = session->record.T_base_sensor;
  // An identity stands for what nobody told, too.
  if (T_base_sensor.Matrix().isIdentity(1e-9)) {
    return absl::FailedPreconditionError(
        absl::StrCat("session ", trajectory.session.value(),
                     " does not tell how its sensor is mounted on the robot: push a recording that "
                     "has tf_static from base_link (or base_footprint) to the LiDAR, or give "
                     "T_base_sensor when you create the session. If the sensor is at the base, "
                     "--poses-of sensor gives the same poses"));
  }
  const Pose T_sensor_base = T_base_sensor.Inverse();
  for (StampedPose& entry : trajectory.poses) entry.pose = entry.pose * T_sensor_base;
  return absl::OkStatus();
}

int Run(const TrajectoryOptions& options) {
  const absl::Status named = options.format == "kitti"
                                 ? CheckOutputName(options.output, {".txt", ".kitti"})
                                 : CheckOutputName(options.output, {".tum", ".txt"});
  if (!named.ok()) return Fail(kUsage, named);
  if (absl::Status status = io::CheckOutput(options.output); !status.ok()) return FailInput(status);
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const bool is_map = options.frame == "map";
  auto trajectory = (*client)->GetTrajectory(
      RobotId(options.robot), is_map ? TrajectoryFrame::kMap : TrajectoryFrame::kOdom,
      options.segment);
  if (!trajectory.ok()) return FailServer(trajectory.status());
  const bool is_base = options.poses_of == "base";
  if (is_base) {
    const absl::Status moved = MoveToBase(**client, *trajectory);
    if (!moved.ok()) return FailServer(moved);
  }
  const absl::Status written = io::WriteOutput(
      options.output, options.format == "kitti" ? formats::FormatKittiPoses(trajectory->poses)
                                                : formats::FormatTum(trajectory->poses));
  if (!written.ok()) return Fail(kFailed, written);
  if (!io::IsStandardOutput(options.output)) {
    Say("%s: %d poses of %s%s in the %s frame, revision %d%s\n", options.output,
        trajectory->poses.size(), is_base ? "the base of " : "", trajectory->session.value(),
        options.frame, trajectory->revision, SegmentsText(*trajectory, is_map));
  }
  return kOk;
}

}  // namespace

void AddTrajectory(CLI::App& app, Action& action) {
  auto options = std::make_shared<TrajectoryOptions>();
  CLI::App* command =
      app.add_subcommand("trajectory", "Poses of a robot's sensor or base as a TUM or KITTI file");
  AddServerOptions(*command, options->server);
  command
      ->add_option("ROBOT", options->robot,
                   "Robot (its newest session), or a session such as alice-1")
      ->required();
  command
      ->add_option("--frame", options->frame,
                   "map: the merged map's frame, fails until the robot is placed; odom: the "
                   "robot's own frame")
      ->check(CLI::IsMember({"map", "odom"}))
      ->capture_default_str();
  command
      ->add_option("--poses-of", options->poses_of,
                   "Whose poses: sensor, or base, the robot's base_link, if the recording's "
                   "tf_static or the session's creator told how the sensor is mounted")
      ->check(CLI::IsMember({"sensor", "base"}))
      ->capture_default_str();
  command
      ->add_option("--segment", options->segment,
                   "Segment of the session, from 1 on; 0: in odom the last one, in map all that "
                   "lie in one map")
      ->check(NotNegative())
      ->capture_default_str();
  command
      ->add_option("--format", options->format,
                   "tum: stamp, position and quaternion; kitti: the twelve numbers of a matrix, "
                   "without stamp, in the axes of Isthmus' sensor frame")
      ->check(CLI::IsMember({"tum", "kitti"}))
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "FILE; - for stdout")->required();
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
