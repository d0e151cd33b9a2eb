#include "client/console/drive_orders.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace isthmus::cli {
namespace {

// The heading from each point to the next; the last keeps its predecessor's.
double HeadingAt(const RobotDrive& drive, size_t point) {
  if (drive.way.size() < 2) return 0;
  const size_t from = std::min(point, drive.way.size() - 2);
  const Eigen::Vector3d ahead = drive.way[from + 1] - drive.way[from];
  return std::atan2(ahead.y(), ahead.x());
}

Json PoseAt(const RobotDrive& drive, size_t point) {
  const Eigen::Vector3d& at = drive.way[point];
  const double half = HeadingAt(drive, point) / 2;
  return {{"header", {{"frame_id", "map"}}},
          {"pose",
           {{"position", {{"x", at.x()}, {"y", at.y()}, {"z", at.z()}}},
            {"orientation", {{"x", 0}, {"y", 0}, {"z", std::sin(half)}, {"w", std::cos(half)}}}}}};
}

std::string MapOf(const RobotDrive& drive, const MatchGraph& graph) {
  const auto placed = std::find_if(
      graph.placements.begin(), graph.placements.end(),
      [&](const PlacedSession& one) { return one.placement.session == drive.session; });
  return placed == graph.placements.end() ? std::string() : placed->placement.reference.value();
}

Json OrderOf(const RobotDrive& drive, const Match& match, const std::string& map) {
  Json order = {
      {"version", "2.1.0"},
      {"serialNumber", drive.robot.value()},
      {"orderId", absl::StrCat(match.a.value(), "~", match.b.value(), "@", match.computed_ns)},
      {"orderUpdateId", 0},
      {"nodes", Json::array()},
      {"edges", Json::array()}};
  const auto name = [](size_t point) { return absl::StrCat("way-", point); };
  for (size_t i = 0; i < drive.way.size(); ++i) {
    order["nodes"].push_back({{"nodeId", name(i)},
                              {"sequenceId", 2 * i},
                              {"released", true},
                              {"nodePosition",
                               {{"x", drive.way[i].x()},
                                {"y", drive.way[i].y()},
                                {"theta", HeadingAt(drive, i)},
                                {"mapId", map}}},
                              {"actions", Json::array()}});
    if (i == 0) continue;
    order["edges"].push_back({{"edgeId", absl::StrCat(name(i - 1), "-", i)},
                              {"sequenceId", 2 * i - 1},
                              {"released", true},
                              {"startNodeId", name(i - 1)},
                              {"endNodeId", name(i)},
                              {"actions", Json::array()}});
  }
  return order;
}

}  // namespace

Json NavigationGoals(const MatchGraph& graph) {
  Json document = {{"goals", Json::array()}};
  for (const MatchEdge& edge : graph.matches) {
    for (const RobotDrive& drive : edge.asked_drives) {
      Json poses = Json::array();
      for (size_t i = 0; i < drive.way.size(); ++i) poses.push_back(PoseAt(drive, i));
      document["goals"].push_back(
          {{"robot", drive.robot.value()}, {"goal", {{"poses", std::move(poses)}}}});
    }
  }
  return document;
}

Json VehicleOrders(const MatchGraph& graph) {
  Json document = {{"orders", Json::array()}};
  for (const MatchEdge& edge : graph.matches) {
    for (const RobotDrive& drive : edge.asked_drives) {
      document["orders"].push_back(OrderOf(drive, edge.match, MapOf(drive, graph)));
    }
  }
  return document;
}

}  // namespace isthmus::cli
