// isthmus odometry: the trajectory of one recorded drive, without a server.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "client/cli/command.h"
#include "client/cli/embedded_server.h"
#include "client/cli/exit_code.h"
#include "client/cli/json.h"
#include "client/cli/push_scans.h"
#include "client/cli/scan_options.h"
#include "core/codec/file_io.h"
#include "core/codec/tum.h"

namespace isthmus::cli {
namespace {

struct Options {
  ScanOptions scans;
  std::string sensor, odometry, output, timing;
  bool json = false;
};

std::string TimingCsv(const PushSummary& summary) {
  std::string csv = "scan,features_ms,matching_ms,map_ms,total_ms\n";
  for (const client::ScanAck& ack : summary.acks) {
    if (ack.outcome != client::ScanOutcome::kProcessed) continue;
    const client::ScanTiming& t = ack.timing;
    absl::StrAppendFormat(&csv, "%d,%.3f,%.3f,%.3f,%.3f\n", ack.sequence - 1, t.features_ms,
                          t.matching_ms, t.map_ms, t.total_ms);
  }
  return csv;
}

void Report(const PushSummary& summary, size_t poses, const Options& options) {
  if (options.json) {
    Print({{"file", options.output},
           {"sensor", options.sensor},
           {"poses", poses},
           {"rejected", summary.scans.rejected},
           {"unreadable", summary.unreadable},
           {"odometry_ms_mean", summary.mean_ms},
           {"seconds", summary.seconds}});
    return;
  }
  absl::PrintF("%s: %d poses (%s), %d scans rejected, %d unreadable; %.1f ms per scan, %.1f s\n",
               options.output, poses, options.sensor, summary.scans.rejected, summary.unreadable,
               summary.mean_ms, summary.seconds);
}

int Run(Options options) {
  int code = kOk;
  const auto folder = OpenScans(options.scans, options.sensor, code);
  if (!folder) return code;
  const auto server = EmbeddedServer::Start({});
  if (!server.ok()) return Fail(kFailed, server.status());
  client::Client& client = (*server)->client();
  PushOptions push;
  push.robot = "robot";
  push.sensor = options.sensor;
  push.odometry = options.odometry;
  const auto summary = PushFolder(client, *folder, push);
  if (!summary.ok()) return FailServer(summary.status());
  if (summary->scans.processed == 0) {
    return FailInput(absl::InvalidArgumentError(absl::StrCat(
        "none of the ", folder->size(), " scans could be used: ", summary->first_rejection)));
  }
  const auto trajectory = client.GetTrajectory(RobotId("robot"), client::Frame::kOdom);
  if (!trajectory.ok()) return FailServer(trajectory.status());
  absl::Status written = codec::WriteTum(options.output, trajectory->poses);
  if (written.ok() && !options.timing.empty()) {
    written = codec::WriteFile(options.timing, TimingCsv(*summary));
  }
  if (!written.ok()) return Fail(kFailed, written);
  Report(*summary, trajectory->poses.size(), options);
  return kOk;
}

}  // namespace

void AddOdometry(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("odometry", "Trajectory of a folder of scans; needs no server");
  AddScanOptions(*command, options->scans);
  command->add_option("--sensor", options->sensor,
                      "vlp16, hdl32, hdl64, os1-64, ...; without it what the folder tells");
  command
      ->add_option("--rate", options->scans.rate_hz,
                   "Scans per second of the stamps, where there is no times.txt")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "FILE.tum, T_odom_sensor at the END of scans")
      ->required();
  command->add_option("--timing", options->timing,
                      "FILE.csv with one row per processed scan: "
                      "scan,features_ms,matching_ms,map_ms,total_ms");
  AddOdometryMode(*command, options->odometry);
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
