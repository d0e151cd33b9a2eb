// isthmus trajectory: where a robot's sensor was, scan by scan.
#include <absl/strings/str_format.h>

#include "client/cli/command.h"
#include "client/cli/exit_code.h"
#include "core/codec/tum.h"

namespace isthmus::cli {
namespace {

struct Options {
  ServerOptions server;
  std::string robot, frame = "map", output;
};

int Run(const Options& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto trajectory = (*client)->GetTrajectory(
      RobotId(options.robot), options.frame == "map" ? client::Frame::kMap : client::Frame::kOdom);
  if (!trajectory.ok()) return FailServer(trajectory.status());
  const absl::Status written = codec::WriteTum(options.output, trajectory->poses);
  if (!written.ok()) return Fail(kFailed, written);
  if (options.output != "/dev/stdout") {
    absl::PrintF("%s: %d poses of %s in the %s frame, revision %d\n", options.output,
                 trajectory->poses.size(), trajectory->session.value(), options.frame,
                 trajectory->revision);
  }
  return kOk;
}

}  // namespace

void AddTrajectory(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("trajectory", "Poses of a robot's sensor as a TUM file");
  AddServerOptions(*command, options->server);
  command->add_option("ROBOT", options->robot)->required();
  command
      ->add_option("--frame", options->frame,
                   "map: the merged map's, fails until the robot is placed; odom: the robot's own")
      ->check(CLI::IsMember({"map", "odom"}))
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "FILE.tum; /dev/stdout to print")->required();
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
