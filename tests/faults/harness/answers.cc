#include "tests/faults/harness/answers.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <stdexcept>
#include <thread>
#include <tuple>

#include "tests/faults/harness/or_throw.h"
#include "tests/faults/harness/robot.h"

namespace isthmus::faults {
namespace {

// Answers travel as doubles and floats; placements are optimised anew at a start.
constexpr double kSameM = 1e-4;

MapInfo Settled(client::Client& client) {
  for (;;) {
    MapInfo info = OrThrow(client.GetMapInfo());
    if (info.settled) return info;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

std::vector<MapPoint> PointsOf(client::Client& client, uint32_t component) {
  std::vector<MapPoint> points;
  RegionQuery query;
  query.component = component;
  const absl::Status status = client.QueryRegion(query, [&](const RegionChunk& chunk) {
    points.insert(points.end(), chunk.points.begin(), chunk.points.end());
    return true;
  });
  if (!status.ok()) throw std::runtime_error(status.ToString());
  std::sort(points.begin(), points.end(), [](const MapPoint& a, const MapPoint& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  });
  return points;
}

std::string TrajectoryDifference(const Trajectory& a, const Trajectory& b) {
  if (a.size() != b.size()) return absl::StrCat(b.size(), " poses instead of ", a.size());
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i].stamp_ns != b[i].stamp_ns ||
        (a[i].pose.translation() - b[i].pose.translation()).norm() > kSameM) {
      return absl::StrCat("pose ", i, " is another");
    }
  }
  return {};
}

bool Same(const SubmapStatus& a, const SubmapStatus& b) {
  return a.info.id == b.info.id && a.info.first_sequence == b.info.first_sequence &&
         a.info.last_sequence == b.info.last_sequence && a.info.point_count == b.info.point_count &&
         a.component == b.component &&
         (a.T_map_submap.translation() - b.T_map_submap.translation()).norm() <= kSameM;
}

bool Same(const SessionStatus& a, const SessionStatus& b) {
  return a.record.id == b.record.id && a.record.robot == b.record.robot &&
         a.record.sensor == b.record.sensor && a.record.state == b.record.state &&
         a.record.created_ns == b.record.created_ns && a.submap_count == b.submap_count &&
         a.point_count == b.point_count && a.durable_sequence == b.durable_sequence;
}

// By their coordinates' order; those on the border between two voxels may differ in their last bit.
std::string PointsDifference(const std::vector<MapPoint>& a, const std::vector<MapPoint>& b) {
  if (a.size() != b.size()) return absl::StrCat(b.size(), " points instead of ", a.size());
  for (size_t i = 0; i < a.size(); ++i) {
    if (std::abs(a[i].x - b[i].x) > kSameM) return absl::StrCat("point ", i, " is another");
  }
  return {};
}

}  // namespace

Answers AskAll(const std::string& address) {
  const auto client = OrThrow(client::Client::Connect(PatientClient(address)));
  Answers answers;
  const MapInfo info = Settled(*client);
  answers.sessions = OrThrow(client->ListSessions());
  answers.submaps = OrThrow(client->ListSubmaps());
  std::set<RobotId> robots;
  for (const SessionStatus& session : answers.sessions) robots.insert(session.record.robot);
  for (const RobotId& robot : robots) {
    for (const TrajectoryFrame frame : {TrajectoryFrame::kOdom, TrajectoryFrame::kMap}) {
      answers.trajectories.push_back(OrThrow(client->GetTrajectory(robot, frame)).poses);
    }
  }
  for (const Component& component : info.components) {
    answers.points.push_back(PointsOf(*client, component.component));
  }
  return answers;
}

std::string Difference(const Answers& wanted, const Answers& answers) {
  if (!std::equal(wanted.sessions.begin(), wanted.sessions.end(), answers.sessions.begin(),
                  answers.sessions.end(),
                  [](const auto& a, const auto& b) { return Same(a, b); })) {
    return "the sessions are others";
  }
  if (!std::equal(wanted.submaps.begin(), wanted.submaps.end(), answers.submaps.begin(),
                  answers.submaps.end(), [](const auto& a, const auto& b) { return Same(a, b); })) {
    return "the submaps are others";
  }
  for (size_t i = 0; i < wanted.trajectories.size(); ++i) {
    const std::string found = TrajectoryDifference(wanted.trajectories[i], answers.trajectories[i]);
    if (!found.empty()) return absl::StrCat("trajectory ", i, ": ", found);
  }
  if (wanted.points.size() != answers.points.size()) return "the components are others";
  for (size_t i = 0; i < wanted.points.size(); ++i) {
    const std::string found = PointsDifference(wanted.points[i], answers.points[i]);
    if (!found.empty()) return absl::StrCat("component ", i, ": ", found);
  }
  return {};
}

}  // namespace isthmus::faults
