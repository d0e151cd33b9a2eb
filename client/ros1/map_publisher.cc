#include "client/ros1/map_publisher.h"

#include <absl/time/clock.h>
#include <ros/console.h>

#include <algorithm>
#include <string>

#include "client/ros1/graph_markers.h"
#include "client/ros1/limits.h"
#include "client/ros1/map_cloud.h"

namespace isthmus::ros1 {
namespace {

// The component that the home session lies in, or the largest if there is no home. Null: there is
// none yet.
const Component* Choose(const MapInfo& info, const std::optional<SessionId>& home) {
  const auto found = std::find_if(
      info.components.begin(), info.components.end(), [&home](const Component& component) {
        return !home || std::find(component.sessions.begin(), component.sessions.end(), *home) !=
                            component.sessions.end();
      });
  return found == info.components.end() ? nullptr : &*found;
}

}  // namespace

MapPublisher::MapPublisher(ros::NodeHandle& node, const Parameters& parameters, Robot robot)
    : parameters_(parameters),
      robot_(std::move(robot)),
      map_(node.advertise<sensor_msgs::PointCloud2>("map", 1, /*latch=*/true)),
      graph_(node.advertise<visualization_msgs::MarkerArray>("match_graph", 1, /*latch=*/true)),
      thread_([this] { Run(); }) {}

MapPublisher::~MapPublisher() {
  {
    MutexLock lock(&mutex_);
    ending_ = true;
    changed_.SignalAll();
  }
  thread_.join();
}

bool MapPublisher::is_ending() const {
  MutexLock lock(&mutex_);
  return ending_;
}

bool MapPublisher::WaitForNext() {
  const absl::Time deadline = absl::Now() + absl::Seconds(parameters_.map.period_s);
  MutexLock lock(&mutex_);
  while (!ending_ && !changed_.WaitWithDeadline(&mutex_, deadline)) {
  }
  return !ending_;
}

void MapPublisher::Run() {
  client::ClientOptions options;
  options.address = parameters_.server;
  options.require_server = false;
  options.backoff.max_attempts = 1;  // The next look is the next attempt.
  options.call_timeout_s = kCallTimeoutS;
  options.transfer_timeout_s = kMapTimeoutS;
  auto client = client::Client::Connect(options);
  if (!client.ok()) {
    ROS_ERROR("no map: %s", std::string(client.status().message()).c_str());
    return;
  }
  client_ = *std::move(client);
  do {
    const absl::Status status = Look();
    if (!status.ok() && !is_ending()) {
      ROS_WARN_THROTTLE(kComplaintPeriodS, "the map is not up to date: %s",
                        std::string(status.message()).c_str());
    }
  } while (WaitForNext());
}

absl::Status MapPublisher::Look() {
  std::optional<SessionId> home;
  if (robot_.home) {
    home = robot_.home();
    if (home->empty()) return absl::OkStatus();
  }
  const auto info = client_->GetMapInfo();
  if (!info.ok()) return info.status();
  const Component* const component = Choose(*info, home);
  if (component == nullptr) return absl::OkStatus();
  if (robot_.on_joined) {
    robot_.on_joined({component->sessions.begin(), component->sessions.end()});
  }
  if (!parameters_.map.publish) return absl::OkStatus();
  absl::Status status = PublishGraph(component->component, info->revision);
  if (map_version_ != Version(component->component, info->revision)) {
    status.Update(PublishMap(component->component));
  }
  return status;
}

absl::Status MapPublisher::PublishGraph(uint32_t component, int64_t revision) {
  const auto graph = client_->GetMatchGraph();
  if (!graph.ok()) return graph.status();
  if (submaps_version_ != Version(component, revision)) {
    auto submaps = client_->ListSubmaps();
    if (!submaps.ok()) return submaps.status();
    submaps_version_ = Version(component, submaps->revision);
    submaps_ = *std::move(submaps);
  }
  graph_.publish(MakeMarkers(
      *graph, submaps_,
      {parameters_.frames.map, ros::Time::now(), component, parameters_.map.marker_size_m}));
  return absl::OkStatus();
}

absl::Status MapPublisher::PublishMap(uint32_t component) {
  RegionQuery query;
  query.component = component;
  query.wants_label = true;
  query.resolution_m = parameters_.map.resolution_m;
  for (int i = 0; i <= kMaxCoarsenings; ++i, query.resolution_m *= 2) {
    MapCloud cloud(static_cast<size_t>(parameters_.map.max_points));
    const absl::Status status = client_->QueryRegion(
        query, [&](const RegionChunk& chunk) { return cloud.Add(chunk) && !is_ending(); });
    if (cloud.is_full()) {
      ROS_WARN_THROTTLE(kComplaintPeriodS,
                        "the map has more than %d points at %g m: it is shown coarser; set "
                        "~map_resolution or ~map_max_points higher",
                        parameters_.map.max_points, query.resolution_m);
      continue;
    }
    if (!status.ok()) return status;
    map_version_ = Version(component, cloud.revision());
    map_.publish(cloud.Take(parameters_.frames.map, ros::Time::now()));
    return absl::OkStatus();
  }
  return absl::ResourceExhaustedError("the map does not fit; set ~map_max_points higher");
}

}  // namespace isthmus::ros1
