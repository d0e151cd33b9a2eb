// isthmus push: recorded drives, and live sensors, become robots.
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <map>
#include <string>

#include "client/cli/gnss_anchors.h"
#include "client/cli/push_report.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/interruption.h"
#include "client/console/localise_scans.h"
#include "client/console/numbers.h"
#include "client/console/push_scans.h"
#include "client/console/recording_options.h"
#include "client/console/say.h"

namespace isthmus::cli {
namespace {

struct PushArguments {
  ServerOptions server{.attempts = kPatientAttempts};
  std::string path, robot;
  RecordingOptions recording;
  PushOptions push;
  std::string pace = "max";
  bool localise = false;
  std::vector<std::string> gnss;  // TOPIC or TOPIC=ROBOT.
  std::string in_map_of, poses;
  bool json = false;
};

PushReportOptions ReportOptionsOf(const PushArguments& options) {
  return {options.json, options.push.finish, options.push.spool, options.poses};
}

// Every robot has a name, and one of its own.
absl::Status NameRobots(const PushArguments& options, std::vector<RobotScans>& robots) {
  if (robots.size() > 1 && !options.robot.empty()) {
    return absl::InvalidArgumentError(
        "--robot names one robot: name those of several topics with --topic TOPIC=ROBOT");
  }
  for (RobotScans& robot : robots) {
    if (!options.robot.empty()) robot.robot = options.robot;
    if (robot.robot.empty()) {
      return absl::InvalidArgumentError(
          robot.topic.empty()
              ? "name the robot with --robot"
              : absl::StrCat("name the robot with --robot, or --topic ", robot.topic, "=ROBOT"));
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<GnssSummary>> AnchorAll(client::Client& client,
                                                   const std::vector<GnssOfRobot>& gnss,
                                                   const std::vector<PushSummary>& pushed) {
  std::vector<GnssSummary> all;
  for (const GnssOfRobot& of_robot : gnss) {
    for (const PushSummary& summary : pushed) {
      if (summary.robot != of_robot.robot) continue;
      auto anchored = AnchorByFixes(client, of_robot, summary.session);
      if (!anchored.ok()) return anchored.status();
      all.push_back(*std::move(anchored));
    }
  }
  return all;
}

int Run(PushArguments options) {
  double hz = 0;
  if (options.pace != "max") {
    if (!absl::SimpleAtod(options.pace, &hz) || !(hz > 0)) {
      return Fail(kUsage, absl::InvalidArgumentError(absl::StrCat(
                              "--rate is a frequency in Hz or `max`, not '", options.pace, "'")));
    }
    options.push.pace_hz = hz;
    options.recording.read.rate_hz = hz;
  }
  const bool is_live = options.path.rfind("udp://", 0) == 0;
  options.push.is_live = is_live;
  if (options.push.session.when_behind == WhenBehind::kKeepNewest && hz == 0 && !is_live) {
    return Fail(kUsage, absl::InvalidArgumentError(
                            "--when-behind keep-newest would skip most scans of a recording that "
                            "is pushed at full speed: give its rate too, for example --rate 10"));
  }
  PushControl control;
  const Interruption interruption([&control, has_spool = !options.push.spool.empty()] {
    if (!control.Stop()) _exit(kInterrupted);
    if (has_spool) return;
    Warn(
        "\nisthmus: interrupted: waiting for the acknowledgements of sent scans; press Ctrl-C "
        "again to end at once\n");
  });
  const auto recording = readers::OpenRecording(options.path);
  if (!recording.ok()) return FailInput(recording.status());
  auto robots = OpenRobots(**recording, options.path, options.recording);
  if (!robots.ok()) return FailInput(robots.status());
  if (absl::Status status = NameRobots(options, *robots); !status.ok()) return Fail(kUsage, status);
  const auto gnss = ReadGnss(**recording, options.gnss, *robots);
  if (!gnss.ok()) return FailInput(gnss.status());
  const auto client =
      ConnectPatiently(options.server, /*may_begin_alone=*/!options.push.spool.empty());
  if (!client.ok()) return FailServer(client.status());
  if (options.localise) {
    if (robots->size() > 1) {
      return Fail(kUsage, absl::InvalidArgumentError("--localise follows one robot at a time"));
    }
    const auto places = LocaliseRobot(**client, std::move(robots->front()), options.in_map_of,
                                      options.push, control);
    return places.ok() ? ReportPlaces(*places, ReportOptionsOf(options))
                       : FailServer(places.status());
  }
  const auto summaries = PushRobots(**client, *std::move(robots), options.push, control);
  if (!summaries.ok()) return FailServer(summaries.status());
  const auto anchored = AnchorAll(**client, *gnss, *summaries);
  const int code = ReportPush(*summaries, anchored.ok() ? *anchored : std::vector<GnssSummary>(),
                              ReportOptionsOf(options));
  return anchored.ok() ? code : FailServer(anchored.status());
}

}  // namespace

void AddPush(CLI::App& app, Action& action) {
  auto options = std::make_shared<PushArguments>();
  CLI::App* command = app.add_subcommand("push", "Push a recording, or a live sensor, as a robot");
  AddServerOptions(*command, options->server);
  command
      ->add_option("PATH", options->path,
                   "Folder of scans, .bag, .mcap, .db3, .pcap, or udp://[ADDRESS]:PORT; isthmus "
                   "info PATH shows its contents")
      ->required();
  command->add_option("--robot", options->robot, "Name of the robot");
  AddRecordingOptions(*command, options->recording);
  command
      ->add_option("--rate", options->pace,
                   "Scans per second, or max: as fast as the server accepts them. Also gives the "
                   "stamps if the recording has none (max: 10 Hz)")
      ->capture_default_str();
  command
      ->add_option("--resolution", options->push.resolution_m,
                   "Compress: round coordinates to this many metres; 0: send every bit")
      ->check(Between(0.0, 0.1))
      ->capture_default_str();
  AddOdometryMode(*command, options->push.session.odometry);
  command
      ->add_option("--when-behind", options->push.session.when_behind,
                   "If scans come faster than the server processes them: wait, or keep-newest, "
                   "which skips the oldest waiting scan so that poses are of the newest")
      ->transform(CLI::CheckedTransformer(std::map<std::string, WhenBehind>{
          {"wait", WhenBehind::kWait}, {"keep-newest", WhenBehind::kKeepNewest}}))
      ->option_text("ENUM:{wait,keep-newest}=wait");
  command->add_flag("--finish,!--no-finish", options->push.finish,
                    "Finish the session at the end (default)");
  command->add_option("--spool", options->push.spool,
                      "Keep scans in this folder until they are durable, so that no scan is lost "
                      "or doubled if anything fails: the same command continues after the last "
                      "scan, by stamps. Waits without limit for an unreachable server");
  command
      ->add_flag("--new-session", options->push.new_session,
                 "With --spool: put the remaining scans into a new session if theirs is deleted or "
                 "finished")
      ->needs("--spool");
  command
      ->add_flag("--keyframes", options->push.keyframes,
                 "Compute odometry here and send submaps instead of scans, a tenth of the bytes: "
                 "for links that are slow or often down")
      ->excludes("--spool")
      ->excludes("--when-behind");
  command
      ->add_flag("--localise", options->localise,
                 "Only locate the robot in the existing map; the map does not grow")
      ->excludes("--keyframes");
  command
      ->add_option("--gnss", options->gnss,
                   "Anchor the map by the fixes on this topic (NavSatFix, NMEA of a .pcap); "
                   "TOPIC=ROBOT for each of several robots")
      ->take_all()
      ->excludes("--localise");
  command
      ->add_option("--in-map-of", options->in_map_of,
                   "With --localise: locate it in this robot's map instead of the largest")
      ->needs("--localise");
  command
      ->add_option("--poses", options->poses,
                   "With --localise: FILE.tum of T_map_sensor at the END of scans")
      ->needs("--localise");
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
