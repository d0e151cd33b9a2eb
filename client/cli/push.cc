// isthmus push: recorded drives, and live sensors, become robots.
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <unistd.h>

#include "client/cli/commands.h"
#include "client/cli/gnss_anchors.h"
#include "client/console/exit_code.h"
#include "client/console/interruption.h"
#include "client/console/json.h"
#include "client/console/localise_scans.h"
#include "client/console/push_scans.h"
#include "client/console/recording_options.h"
#include "client/console/tracking_text.h"
#include "core/formats/tum.h"

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

Json SummaryJson(const PushSummary& summary) {
  return {{"session", summary.session.value()},
          {"robot", summary.robot},
          {"sensor", summary.sensor},
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
          {"reconnects", summary.scans.reconnects},
          {"interrupted", summary.is_interrupted},
          {"assumptions", summary.assumptions}};
}

void PrintText(const PushSummary& summary) {
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

// Of the robot, if any are.
const GnssSummary* AnchorsOf(const std::string& robot, const std::vector<GnssSummary>& anchored) {
  for (const GnssSummary& gnss : anchored) {
    if (gnss.robot == robot) return &gnss;
  }
  return nullptr;
}

Json GnssJson(const GnssSummary* gnss) {
  if (gnss == nullptr) return nullptr;
  return {{"topic", gnss->topic},       {"fixes", gnss->fixes}, {"submaps", gnss->submaps},
          {"anchored", gnss->anchored}, {"wild", gnss->wild},   {"sets_datum", gnss->is_new_datum}};
}

void PrintText(const GnssSummary& gnss) {
  absl::PrintF("%s: %d of %d submaps anchored by the %d fixes of %s\n", gnss.robot, gnss.anchored,
               gnss.submaps, gnss.fixes, gnss.topic);
  if (gnss.wild > 0) {
    absl::PrintF("%s: %d submaps are not anchored: their fixes are far from where the way leads\n",
                 gnss.robot, gnss.wild);
  }
  if (!gnss.is_new_datum) return;
  absl::PrintF("%s: the first fix is the site's datum: latitude %.9f, longitude %.9f, %.3f m\n",
               gnss.robot, gnss.datum.latitude_deg, gnss.datum.longitude_deg,
               gnss.datum.altitude_m);
}

int Report(const std::vector<PushSummary>& summaries, const std::vector<GnssSummary>& anchored,
           const PushArguments& options) {
  if (options.json) {
    Json robots = Json::array();
    for (const PushSummary& summary : summaries) {
      robots.push_back(SummaryJson(summary));
      robots.back()["gnss"] = GnssJson(AnchorsOf(summary.robot, anchored));
    }
    Print(summaries.size() == 1 ? robots[0] : Json{{"robots", std::move(robots)}});
  }
  int code = kOk;
  for (const PushSummary& summary : summaries) {
    if (!options.json) {
      PrintText(summary);
      const GnssSummary* gnss = AnchorsOf(summary.robot, anchored);
      if (gnss != nullptr) PrintText(*gnss);
    }
    if (summary.is_interrupted) {
      absl::FPrintF(stderr, "isthmus: %s: interrupted; %s\n", summary.robot,
                    !options.push.spool.empty() ? "the same command goes on"
                    : options.push.finish       ? "the session is finished with what was pushed"
                                                : "the session is open");
      if (code == kOk) code = kInterrupted;
    } else if (summary.used() == 0) {
      code = FailInput(absl::InvalidArgumentError(absl::StrCat(
          "none of the ", summary.acks.size() + summary.unreadable, " scans could be used",
          summary.first_rejection.empty() ? "" : ": ", summary.first_rejection)));
    }
  }
  return code;
}

int ReportPlaces(const LocaliseSummary& summary, const PushArguments& options) {
  if (!options.poses.empty()) {
    const absl::Status written = formats::WriteTum(options.poses, summary.poses);
    if (!written.ok()) return Fail(kFailed, written);
  }
  if (options.json) {
    Print({{"robot", summary.robot},
           {"sensor", summary.sensor},
           {"scans", summary.scans},
           {"located", summary.located},
           {"uncertain", summary.uncertain},
           {"ambiguous", summary.ambiguous},
           {"searching", summary.searching},
           {"rejected", summary.rejected},
           {"unreadable", summary.unreadable},
           {"first_pose_s", summary.first_pose_s ? Json(*summary.first_pose_s) : Json(nullptr)},
           {"state", ToString(summary.last.state)},
           {"T_map_sensor",
            summary.last.T_map_sensor ? ToJson(*summary.last.T_map_sensor) : Json(nullptr)},
           {"component", summary.last.component},
           {"revision", summary.last.revision},
           {"odometry_ms_mean", summary.odometry_ms},
           {"localising_ms_mean", summary.localising_ms},
           {"seconds", summary.seconds},
           {"interrupted", summary.is_interrupted}});
  } else {
    absl::PrintF(
        "%s: of %d scans %d located, %d uncertain, %d ambiguous, %d searching, %d rejected, %d "
        "unreadable; %s; odometry %.1f ms and localising %.1f ms per scan\n",
        summary.robot, summary.scans, summary.located, summary.uncertain, summary.ambiguous,
        summary.searching, summary.rejected, summary.unreadable,
        summary.first_pose_s ? absl::StrFormat("first pose after %.1f s", *summary.first_pose_s)
                             : "no pose",
        summary.odometry_ms, summary.localising_ms);
  }
  if (summary.is_interrupted) return kInterrupted;
  if (summary.scans == summary.rejected) {
    return FailInput(absl::InvalidArgumentError("none of the scans could be used"));
  }
  return summary.poses.empty() ? kNoAnswer : kOk;
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
  PushControl control;
  const Interruption interruption([&control] {
    if (!control.Stop()) _exit(kInterrupted);
    absl::FPrintF(stderr,
                  "\nisthmus: interrupted: waiting for what was sent to be acknowledged; "
                  "once more to end at once\n");
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
    return places.ok() ? ReportPlaces(*places, options) : FailServer(places.status());
  }
  const auto summaries = PushRobots(**client, *std::move(robots), options.push, control);
  if (absl::IsAlreadyExists(summaries.status())) {
    absl::FPrintF(stderr,
                  "isthmus: nothing left to push: an earlier push with the spool %s sent %s\n",
                  options.push.spool, "everything and finished its session");
    return kOk;
  }
  if (!summaries.ok()) return FailServer(summaries.status());
  const auto anchored = AnchorAll(**client, *gnss, *summaries);
  const int code =
      Report(*summaries, anchored.ok() ? *anchored : std::vector<GnssSummary>(), options);
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
                   "info PATH says what is in it")
      ->required();
  command->add_option("--robot", options->robot, "Name of the robot");
  AddRecordingOptions(*command, options->recording);
  command
      ->add_option("--rate", options->pace,
                   "Scans per second, or max: as fast as the server takes them. Also gives the "
                   "stamps where the recording has none (max: 10 Hz)")
      ->capture_default_str();
  command
      ->add_option("--resolution", options->push.resolution_m,
                   "Compress: round coordinates to this many metres; 0: send every bit")
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
  command->add_flag("--localise", options->localise,
                    "Only say where the robot is in the map there is; the map does not grow");
  command
      ->add_option("--gnss", options->gnss,
                   "Anchor the map by the fixes on this topic (NavSatFix, NMEA of a .pcap); "
                   "TOPIC=ROBOT for each of several robots")
      ->take_all()
      ->excludes("--localise");
  command
      ->add_option("--in-map-of", options->in_map_of,
                   "With --localise: in the map that this robot is in, not the largest")
      ->needs("--localise");
  command
      ->add_option("--poses", options->poses,
                   "With --localise: FILE.tum of T_map_sensor at the END of scans")
      ->needs("--localise");
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
