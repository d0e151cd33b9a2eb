// isthmus transform: where one robot's frame lies in another's.

#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/pose_text.h"
#include "client/console/say.h"

namespace isthmus::cli {
namespace {

struct TransformOptions {
  ServerOptions server;
  std::string a, b;
  bool json = false;
};

int Run(const TransformOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto transform = (*client)->GetTransform(RobotId(options.a), RobotId(options.b));
  if (!transform.ok()) return FailServer(transform.status());
  if (options.json) {
    Print({{"robot_a", options.a},
           {"robot_b", options.b},
           {"revision", transform->revision},
           {"t_a_b", ToJson(transform->T_a_b)}});
  } else {
    Say("%s in the frame of %s: %s (revision %d)\n", options.b, options.a,
        PoseText(transform->T_a_b), transform->revision);
  }
  return kOk;
}

}  // namespace

void AddTransform(CLI::App& app, Action& action) {
  auto options = std::make_shared<TransformOptions>();
  CLI::App* command = app.add_subcommand(
      "transform", "The pose of ROBOT_B's odom frame in ROBOT_A's; fails until it is known");
  AddServerOptions(*command, options->server);
  command
      ->add_option("ROBOT_A", options->a,
                   "The robot (its newest session), or session, in whose frame the answer is")
      ->required();
  command->add_option("ROBOT_B", options->b, "The robot or session whose frame is located")
      ->required();
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
