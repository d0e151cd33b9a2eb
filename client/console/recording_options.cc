#include "client/console/recording_options.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <CLI/Error.hpp>
#include <cstdint>
#include <map>
#include <utility>

#include "client/console/numbers.h"
#include "client/console/pose_text.h"
#include "client/console/say.h"
#include "client/readers/static_frames.h"

namespace isthmus::cli {
namespace {

using readers::Recording;
using readers::ScanTopic;
using readers::StampMeaning;

struct ChosenTopic {
  size_t index = 0;
  std::string robot;
};

std::string ListTopics(const std::vector<ScanTopic>& topics) {
  return absl::StrJoin(topics, "\n", [](std::string* out, const ScanTopic& topic) {
    absl::StrAppend(out, "  ", topic.name, "  ", topic.type);
  });
}

absl::StatusOr<ChosenTopic> FindTopic(const std::vector<ScanTopic>& topics,
                                      const std::string& wanted) {
  for (size_t i = 0; i < topics.size(); ++i) {
    const std::string& name = topics[i].name;
    if (wanted == name) return ChosenTopic{i, ""};
    // Names of topics may hold a "=" themselves.
    if (wanted.size() > name.size() + 1 && wanted.starts_with(name + "=")) {
      return ChosenTopic{i, wanted.substr(name.size() + 1)};
    }
  }
  return absl::NotFoundError(
      absl::StrCat("no scans on ", wanted, "; there are\n", ListTopics(topics)));
}

absl::StatusOr<std::vector<ChosenTopic>> ChooseTopics(const Recording& recording,
                                                      const std::string& path,
                                                      const RecordingOptions& options) {
  const std::vector<ScanTopic>& topics = recording.scan_topics();
  std::vector<ChosenTopic> chosen;
  for (const std::string& wanted : options.topics) {
    absl::StatusOr<ChosenTopic> found = FindTopic(topics, wanted);
    if (!found.ok()) return found.status();
    for (const ChosenTopic& other : chosen) {
      if (other.index == found->index) {
        return absl::InvalidArgumentError(absl::StrCat("--topic names ", wanted, " twice"));
      }
      if (!other.robot.empty() && other.robot == found->robot) {
        return absl::InvalidArgumentError(
            absl::StrCat("two topics of robot ", other.robot,
                         ": one robot has one LiDAR; give the second topic another name"));
      }
    }
    chosen.push_back(*std::move(found));
  }
  if (!chosen.empty()) return chosen;
  if (topics.size() == 1) return std::vector<ChosenTopic>{{0, ""}};
  return absl::InvalidArgumentError(absl::StrCat(
      path,
      " holds several topics of scans: name one with --topic, or several robots with --topic ",
      topics[0].name, "=NAME --topic ", topics[1].name, "=NAME; there are\n", ListTopics(topics)));
}

// The sensor's mounting, if the recording tells it; said unless it is upright in the middle.
void Mount(const readers::StaticFrames& frames, RobotScans& robot) {
  const readers::RecordedScan* first = robot.reader->first();
  if (first == nullptr) return;
  robot.frame = first->frame;
  const std::string base = frames.BaseOf(robot.frame);
  robot.T_base_sensor = frames.Between(base, robot.frame);
  if (!robot.T_base_sensor || robot.T_base_sensor->Matrix().isIdentity(1e-9)) return;
  Warn("isthmus: %s: %s is mounted on %s at %s (tf_static)\n", robot.topic, robot.frame, base,
       PoseText(*robot.T_base_sensor));
}

}  // namespace

void AddRecordingOptions(CLI::App& command, RecordingOptions& options) {
  command
      .add_option("--topic", options.topics,
                  "Topic of the scans, or TOPIC=ROBOT for each of several robots; without it the "
                  "recording's only topic")
      ->take_all();
  AddReadOptions(command, options.read);
  command.add_option("--from", options.read.from, "First scan of the recording, counted from 0")
      ->check(NotNegative())
      ->capture_default_str();
  command.add_option("--to", options.read.to, "Last scan of the recording, included")
      ->check(NotNegative());
}

void AddReadOptions(CLI::App& command, readers::ReadOptions& options) {
  command.add_option("--sensor", options.sensor,
                     "vlp16, hdl32, hdl64, os1-64, ...; without it the recording decides");
  command
      .add_option("--stamps", options.stamps,
                  "Instant of a scan's stamp: by-times of its points (the end if they have none), "
                  "start or end")
      ->transform(CLI::CheckedTransformer(
          std::map<std::string, StampMeaning>{{"by-times", StampMeaning::kByTimes},
                                              {"start", StampMeaning::kStart},
                                              {"end", StampMeaning::kEnd}}))
      ->option_text("ENUM:{by-times,start,end}=by-times");
  command.add_flag_function(
      "--compensated,!--not-compensated",
      [&options](int64_t count) { options.compensated = count > 0; },
      "Scans are motion-compensated already; without it those whose times are all 0, and KITTI's "
      "odometry drives, count as compensated");
  command.add_option("--metadata", options.metadata,
                     "Ouster's JSON; without it the one beside or in the recording");
  command.add_option("--calibration", options.calibration,
                     "Angles of the unit's lasers: Velodyne's YAML, Hesai's or RoboSense's CSV; "
                     "without it the manual's angles, or those that the sensor sends");
}

void AddOdometryMode(CLI::App& command, std::optional<OdometryMode>& mode) {
  const auto parse = [&mode](const std::string& name) {
    const absl::StatusOr<OdometryMode> parsed = ParseOdometryMode(name);
    if (!parsed.ok()) {
      throw CLI::ValidationError("--odometry", std::string(parsed.status().message()));
    }
    mode = *parsed;
  };
  command.add_option_function<std::string>(
      "--odometry", parse,
      "continuous (the best), floam (the paper's two stages) or aloam (for comparison); without it "
      "the server chooses");
}

absl::StatusOr<std::vector<RobotScans>> OpenRobots(const std::string& path,
                                                   const RecordingOptions& options) {
  const auto recording = readers::OpenRecording(path);
  if (!recording.ok()) return recording.status();
  absl::StatusOr<std::vector<RobotScans>> robots = OpenRobots(**recording, path, options);
  for (size_t i = 0; robots.ok() && i < robots->size(); ++i) (*robots)[i].read_again = nullptr;
  return robots;
}

absl::StatusOr<std::vector<RobotScans>> OpenRobots(const Recording& recording,
                                                   const std::string& path,
                                                   const RecordingOptions& options) {
  const absl::StatusOr<std::vector<ChosenTopic>> chosen = ChooseTopics(recording, path, options);
  if (!chosen.ok()) return chosen.status();
  for (const std::string& note : recording.notes()) {
    Warn("isthmus: %s: %s\n", path, note);
  }
  auto transforms = recording.ReadStaticTransforms();
  if (!transforms.ok()) {
    Warn("isthmus: %s: static transforms are not used: %s\n", path,
         std::string(transforms.status().message()));
    transforms.emplace();
  }
  const readers::StaticFrames frames(*transforms);
  std::vector<RobotScans> robots;
  for (const ChosenTopic& topic : *chosen) {
    auto reader = recording.OpenScans(topic.index, options.read);
    if (!reader.ok()) return reader.status();
    RobotScans robot;
    robot.robot = topic.robot;
    robot.topic = recording.scan_topics()[topic.index].name;
    robot.reader = std::make_unique<readers::StartedReader>(*std::move(reader));
    robot.read_again = [&recording, index = topic.index, read = options.read] {
      return recording.OpenScans(index, read);
    };
    robot.sensor = options.read.sensor.empty() ? robot.reader->sensor() : options.read.sensor;
    const std::string what = robot.topic.empty() ? path : robot.topic;
    robot.assumptions = robot.reader->Assumptions();
    for (const std::string& assumption : robot.assumptions) {
      Warn("isthmus: %s: %s\n", what, assumption);
    }
    if (robot.sensor.empty()) {
      robot.sensor = "spinning";
      Warn("isthmus: %s: the sensor is unknown and taken for a spinning one (see --sensor)\n",
           what);
    }
    Mount(frames, robot);
    robots.push_back(std::move(robot));
  }
  return robots;
}

}  // namespace isthmus::cli
