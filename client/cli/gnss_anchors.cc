#include "client/cli/gnss_anchors.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <optional>
#include <utility>

#include "client/cli/anchor_import.h"
#include "client/console/say.h"
#include "client/readers/static_frames.h"

namespace isthmus::cli {
namespace {

// True for the session and a later segment of it: "alice-1", "alice-1.2".
bool IsOf(const SessionId& session, const SessionId& id) {
  return id == session || absl::StartsWith(id.value(), session.value() + ".");
}

absl::StatusOr<std::vector<SubmapInfo>> SubmapsOf(client::Client& client, const std::string& robot,
                                                  const SessionId& session) {
  const auto listed = client.ListSubmaps(RobotId(robot));
  if (!listed.ok()) return listed.status();
  std::vector<SubmapInfo> submaps;
  for (const SubmapStatus& submap : *listed) {
    if (IsOf(session, submap.info.id.session)) submaps.push_back(submap.info);
  }
  return submaps;
}

struct ChosenFixes {
  size_t index = 0;
  std::string robot;  // Empty: not named.
};

absl::StatusOr<ChosenFixes> FindFixes(const std::vector<readers::GnssTopic>& topics,
                                      const std::string& wanted) {
  for (size_t i = 0; i < topics.size(); ++i) {
    if (wanted == topics[i].name) return ChosenFixes{i, ""};
    // Names of topics may hold a "=" themselves.
    if (absl::StartsWith(wanted, topics[i].name + "=")) {
      return ChosenFixes{i, wanted.substr(topics[i].name.size() + 1)};
    }
  }
  if (topics.empty()) return absl::NotFoundError("the recording has no GNSS fixes for --gnss");
  std::string names;
  for (const auto& topic : topics) absl::StrAppend(&names, "\n  ", topic.name);
  return absl::NotFoundError(absl::StrCat("no GNSS fixes on ", wanted, "; there are", names));
}

absl::StatusOr<const RobotScans*> RobotOf(const std::string& name,
                                          const std::vector<RobotScans>& robots) {
  if (name.empty() && robots.size() == 1) return &robots.front();
  for (const RobotScans& robot : robots) {
    if (robot.robot == name) return &robot;
  }
  return absl::InvalidArgumentError(
      name.empty() ? "several robots are pushed: name the robot of the fixes, --gnss TOPIC=ROBOT"
                   : absl::StrCat("--gnss names robot ", name, ", which is not pushed"));
}

// By the recording's static transforms, where they join antenna and LiDAR.
void Mount(const readers::StaticFrames& frames, const RobotScans& robot, GnssOfRobot& gnss) {
  gnss.antenna.R_base_sensor = robot.T_base_sensor.value_or(Pose()).rotation();
  const std::string& frame = gnss.fixes.front().frame;
  const std::optional<Pose> T_sensor_antenna = frames.Between(robot.frame, frame);
  if (!T_sensor_antenna) {
    Warn(
        "isthmus: %s: no static transform gives the place of the antenna (frame '%s'): its fixes "
        "are used as if it were at the LiDAR\n",
        gnss.topic, frame);
    return;
  }
  gnss.antenna.in_sensor = T_sensor_antenna->translation();
}

}  // namespace

absl::StatusOr<std::vector<GnssOfRobot>> ReadGnss(const readers::Recording& recording,
                                                  const std::vector<std::string>& wanted,
                                                  const std::vector<RobotScans>& robots) {
  std::vector<GnssOfRobot> all;
  if (wanted.empty()) return all;
  const auto transforms = recording.ReadStaticTransforms();
  const readers::StaticFrames frames(transforms.ok() ? *transforms
                                                     : std::vector<readers::StaticTransform>());
  for (const std::string& name : wanted) {
    const auto chosen = FindFixes(recording.gnss_topics(), name);
    if (!chosen.ok()) return chosen.status();
    const auto robot = RobotOf(chosen->robot, robots);
    if (!robot.ok()) return robot.status();
    for (const GnssOfRobot& other : all) {
      if (other.robot != (*robot)->robot) continue;
      return absl::InvalidArgumentError(
          absl::StrCat("--gnss gives robot ", other.robot, " two receivers: name one"));
    }
    auto fixes = recording.ReadFixes(chosen->index);
    if (!fixes.ok()) return fixes.status();
    GnssOfRobot& gnss = all.emplace_back();
    gnss.robot = (*robot)->robot;
    gnss.topic = recording.gnss_topics()[chosen->index].name;
    gnss.fixes = *std::move(fixes);
    if (gnss.fixes.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat(gnss.topic, " holds no valid fix: push without --gnss"));
    }
    Mount(frames, **robot, gnss);
  }
  return all;
}

absl::StatusOr<GnssSummary> AnchorByFixes(client::Client& client, const GnssOfRobot& gnss,
                                          const SessionId& session) {
  const auto submaps = SubmapsOf(client, gnss.robot, session);
  if (!submaps.ok()) return submaps.status();
  const auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  const auto made = georeference::AnchorsOfFixes(gnss.fixes, *submaps, info->datum, gnss.antenna);
  if (!made.ok()) return made.status();
  if (made->is_new_datum && !made->anchors.empty()) {
    if (absl::Status status = client.SetDatum(made->datum); !status.ok()) return status;
  }
  const auto put = PutAnchors(client, made->anchors);
  if (!put.ok()) return put.status();
  GnssSummary summary;
  summary.robot = gnss.robot;
  summary.topic = gnss.topic;
  summary.fixes = gnss.fixes.size();
  summary.submaps = static_cast<int>(submaps->size());
  summary.anchored = put->anchored;
  summary.wild = made->wild;
  summary.is_new_datum = made->is_new_datum && !made->anchors.empty();
  summary.datum = made->datum;
  return summary;
}

}  // namespace isthmus::cli
