// isthmus odometry: the trajectory of one recorded drive, without a server.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <unistd.h>

#include <filesystem>
#include <system_error>
#include <vector>

#include "api/convert/session.h"
#include "client/console/exit_code.h"
#include "client/console/interruption.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/offline_commands.h"
#include "client/console/output_name.h"
#include "client/console/push_scans.h"
#include "client/console/recording_options.h"
#include "client/console/say.h"
#include "client/console/tracking_text.h"
#include "client/offline/commands.h"
#include "client/offline/embedded_server.h"
#include "core/formats/tum.h"
#include "core/io/file_io.h"

namespace isthmus::cli {
namespace {

const RobotId kRobot("robot");

struct OdometryOptions {
  RecordingOptions recording;
  std::string path, output, timing;
  std::optional<OdometryMode> odometry;
  bool json = false;
};

std::string TimingCsv(const PushSummary& summary) {
  std::string csv = "scan,features_ms,matching_ms,map_ms,total_ms,segment,tracking\n";
  for (const ScanAck& ack : summary.acks) {
    if (ack.outcome != ScanOutcome::kProcessed) continue;
    const ScanTiming& t = ack.timing;
    absl::StrAppendFormat(&csv, "%d,%.3f,%.3f,%.3f,%.3f,%d,%s\n", ack.sequence - 1, t.features_ms,
                          t.matching_ms, t.map_ms, t.total_ms, ack.segment, ToString(ack.tracking));
  }
  return csv;
}

// "poses.tum" is of the first segment, "poses.2.tum" of the second: no file mixes frames.
std::string FileOf(const std::string& output, uint32_t segment) {
  if (segment == 1) return output;
  const std::filesystem::path path(output);
  std::filesystem::path file = path;
  file.replace_filename(
      absl::StrCat(path.stem().string(), ".", segment, path.extension().string()));
  return file.string();
}

// The files written for a segment.
struct Written {
  std::string file;
  uint32_t segment = 1;
  size_t poses = 0;
};

absl::StatusOr<std::vector<Written>> WriteSegments(client::Client& client, uint32_t segments,
                                                   const std::string& output) {
  std::vector<Written> files;
  for (uint32_t segment = 1; segment <= segments; ++segment) {
    const auto trajectory = client.GetTrajectory(kRobot, TrajectoryFrame::kOdom, segment);
    if (!trajectory.ok()) return trajectory.status();
    const Written& written =
        files.emplace_back(Written{FileOf(output, segment), segment, trajectory->poses.size()});
    absl::Status status = formats::WriteTum(written.file, trajectory->poses);
    if (!status.ok()) return status;
  }
  // A file that an earlier drive left under this name would pass for a segment of this one.
  std::error_code failed;
  uint32_t next = segments + 1;
  while (std::filesystem::remove(FileOf(output, next), failed)) ++next;
  if (failed) {
    return absl::FailedPreconditionError(absl::StrCat("cannot remove ", FileOf(output, next),
                                                      " of an earlier drive: ", failed.message()));
  }
  return files;
}

void ReportJson(const PushSummary& summary, const std::vector<Written>& files, const Loss& loss,
                const OdometryOptions& options) {
  size_t poses = 0;
  Json list = Json::array();
  for (const Written& written : files) {
    poses += written.poses;
    list.push_back(
        {{"segment", written.segment}, {"file", written.file}, {"poses", written.poses}});
  }
  Print({{"file", options.output},
         {"sensor", summary.sensor},
         {"poses", poses},
         {"segments", std::move(list)},
         {"scans", cli::ToJson(convert::ToMessage(summary.state.scans))},
         {"lost", loss.lost},
         {"rejected", summary.scans.rejected},
         {"unreadable", summary.unreadable},
         {"odometry_ms_mean", cli::OrNull(summary.mean_ms)},
         {"seconds", summary.seconds}});
}

int Report(const PushSummary& summary, const std::vector<Written>& files,
           const OdometryOptions& options) {
  Loss loss = LossOf(summary.acks, summary.state.segments);
  loss.lost += summary.unreadable;  // Nobody knows where the robot was then.
  loss.scans += summary.unreadable;
  if (options.json) {
    ReportJson(summary, files, loss, options);
  } else {
    Say("%s: %d poses (%s), %d scans rejected, %d unreadable; %.1f ms per scan, %.1f s\n",
        options.output, files.front().poses, summary.sensor, summary.scans.rejected,
        summary.unreadable, summary.mean_ms.value_or(0), summary.seconds);
    for (size_t i = 1; i < files.size(); ++i) {
      Say("%s: %d poses of segment %d, in a frame of its own\n", files[i].file, files[i].poses,
          files[i].segment);
    }
    Say("%s\n", CountsText(summary.state.scans));
  }
  const std::string degenerate = DegeneracyText(summary.state.scans);
  if (!degenerate.empty()) Warn("isthmus: %s\n", degenerate);
  if (summary.is_interrupted) return kInterrupted;
  if (!loss.IsMuch()) return kOk;
  Warn("isthmus: %s\n", ToString(loss));
  return kLost;
}

int Run(OdometryOptions options) {
  PushControl control;
  const Interruption interruption([&control] {
    if (!control.Stop()) _exit(kInterrupted);
  });
  auto robots = OpenRobots(options.path, options.recording);
  if (!robots.ok()) return FailInput(robots.status());
  if (robots->size() != 1) {
    return Fail(kUsage,
                absl::InvalidArgumentError("give one --topic: a trajectory is of one topic"));
  }
  (*robots)[0].robot = kRobot.value();
  const auto server = EmbeddedServer::Start({});
  if (!server.ok()) return Fail(kFailed, server.status());
  client::Client& client = (*server)->client();
  const auto summaries =
      PushRobots(client, *std::move(robots),
                 {.session = {.odometry = options.odometry}, .resolution_m = 0}, control);
  if (!summaries.ok()) return FailServer(summaries.status());
  const PushSummary& summary = summaries->front();
  if (summary.scans.processed == 0) {
    return FailInput(absl::InvalidArgumentError(
        absl::StrCat("none of the ", summary.acks.size() + summary.unreadable,
                     " scans could be used: ", summary.first_rejection)));
  }
  const auto files = WriteSegments(client, summary.state.segments, options.output);
  if (!files.ok()) return Fail(kFailed, files.status());
  if (!options.timing.empty()) {
    const absl::Status written = io::WriteFile(options.timing, TimingCsv(summary));
    if (!written.ok()) return Fail(kFailed, written);
  }
  return Report(summary, *files, options);
}

}  // namespace

void AddOdometry(CLI::App& app, Action& action) {
  auto options = std::make_shared<OdometryOptions>();
  CLI::App* command = AddOfflineCommand(app, "odometry");
  command
      ->add_option(
          "PATH", options->path,
          "Folder of scans, .bag, .mcap, .db3 or .pcap; isthmus info PATH shows its contents")
      ->required();
  AddRecordingOptions(*command, options->recording);
  command
      ->add_option("--rate", options->recording.read.rate_hz,
                   "Scans per second, for stamps if the recording has none")
      ->check(Positive())
      ->capture_default_str();
  command
      ->add_option("-o,--output", options->output,
                   "FILE.tum, T_odom_sensor at the END of scans; FILE.2.tum for a second segment")
      ->check(OutputNamed({".tum", ".txt"}))
      ->required();
  command->add_option("--timing", options->timing,
                      "FILE.csv with one row per processed scan: "
                      "scan,features_ms,matching_ms,map_ms,total_ms,segment,tracking");
  AddOdometryMode(*command, options->odometry);
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
