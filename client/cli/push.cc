// isthmus push: a recorded drive becomes a robot.
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "client/cli/commands.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/push_scans.h"
#include "client/console/scan_options.h"
#include "client/console/tracking_text.h"

namespace isthmus::cli {
namespace {

struct PushArguments {
  ServerOptions server;
  ScanOptions scans;
  PushOptions push;
  std::string pace = "max";
  bool json = false;
};

void Report(const PushSummary& summary, const PushArguments& options) {
  if (options.json) {
    Print({{"session", summary.session.value()},
           {"robot", options.push.robot},
           {"pushed", summary.scans.pushed},
           {"processed", summary.scans.processed},
           {"rejected", summary.scans.rejected},
           {"before", summary.before},
           {"duplicates", summary.scans.duplicates},
           {"unreadable", summary.unreadable},
           {"durable_sequence", summary.scans.durable_sequence},
           {"scans", ToJson(summary.state.scans)},
           {"lost", LossOf(summary.acks, summary.state.segments).lost},
           {"segments", summary.state.segments},
           {"odometry_ms_mean", summary.mean_ms},
           {"seconds", summary.seconds},
           {"sent_bytes", summary.scans.sent_bytes},
           {"reconnects", summary.scans.reconnects}});
    return;
  }
  if (summary.before > 0) absl::PrintF("went on after scan %d\n", summary.before);
  absl::PrintF(
      "%s: %d scans processed, %d rejected, %d duplicates, %d unreadable; odometry %.1f ms per "
      "scan; durable up to scan %d; %.1f s\n",
      summary.session.value(), summary.scans.processed, summary.scans.rejected,
      summary.scans.duplicates, summary.unreadable, summary.mean_ms, summary.scans.durable_sequence,
      summary.seconds);
  absl::PrintF("%s: %s%s\n", summary.session.value(), CountsText(summary.state.scans),
               SegmentAndLossText(summary.state));
  const Loss loss = LossOf(summary.acks, summary.state.segments);
  if (loss.IsMuch()) absl::PrintF("%s: %s\n", summary.session.value(), ToString(loss));
}

int Run(PushArguments options) {
  double hz = 0;
  if (options.pace != "max") {
    if (!absl::SimpleAtod(options.pace, &hz) || !(hz > 0)) {
      return Fail(kUsage, absl::InvalidArgumentError(absl::StrCat(
                              "--rate is a frequency in Hz or `max`, not '", options.pace, "'")));
    }
    options.push.pace_hz = hz;
    options.scans.rate_hz = hz;
  }
  int code = kOk;
  const auto folder = OpenScans(options.scans, options.push.sensor, code);
  if (!folder) return code;
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto summary = PushFolder(**client, *folder, options.push);
  if (absl::IsAlreadyExists(summary.status())) {
    absl::FPrintF(stderr,
                  "isthmus: nothing left to push: an earlier push with the spool %s sent %s\n",
                  options.push.spool, "everything and finished its session");
    return kOk;
  }
  if (!summary.ok()) return FailServer(summary.status());
  Report(*summary, options);
  if (summary->scans.processed + summary->scans.duplicates + summary->before > 0) return kOk;
  return FailInput(absl::InvalidArgumentError(
      absl::StrCat("none of the ", folder->size(), " scans could be used",
                   summary->first_rejection.empty() ? "" : ": ", summary->first_rejection)));
}

}  // namespace

void AddPush(CLI::App& app, Action& action) {
  auto options = std::make_shared<PushArguments>();
  CLI::App* command = app.add_subcommand("push", "Push a folder of scans as a robot");
  AddServerOptions(*command, options->server);
  AddScanOptions(*command, options->scans);
  command->add_option("--robot", options->push.robot, "Name of the robot")->required();
  command->add_option("--sensor", options->push.sensor,
                      "vlp16, hdl32, hdl64, os1-64, ...; without it what the folder tells");
  command
      ->add_option("--rate", options->pace,
                   "Scans per second, or max: as fast as the server takes them. Also gives the "
                   "stamps where there is no times.txt (max: 10 Hz)")
      ->capture_default_str();
  command
      ->add_option("--resolution", options->push.resolution_m,
                   "Compress: round coordinates to this many metres, e.g. 0.002; 0: send as is")
      ->check(CLI::Range(0.0, 0.1))
      ->capture_default_str();
  AddOdometryMode(*command, options->push.odometry);
  command->add_flag("--finish,!--no-finish", options->push.finish,
                    "Finish the session at the end (default)");
  command->add_option(
      "--spool", options->push.spool,
      "Keep scans in this folder until they are durable, so that nothing is lost "
      "or doubled whatever is cut off: the same command again goes on, by the stamps "
      "of the scans. Waits for a server out of reach as long as it takes");
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
