#include "server/pipeline/replica_pipeline.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "core/caught.h"

namespace isthmus::server {
namespace {

// Counts, for the limits on robots' sessions are the other server's affair, and so is the log of
// events: this one's are in its own.
PipelineOptions ForReading(PipelineOptions options) {
  options.retention = {};
  options.on_event = nullptr;
  return options;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Pipeline>> Pipeline::OpenReplica(
    const PipelineOptions& options, std::unique_ptr<storage::MapStore> store,
    std::unique_ptr<storage::MapFollower> follower, const Clock& clock) {
  try {
    auto pipeline =
        std::make_unique<ReplicaPipeline>(options, std::move(store), std::move(follower), clock);
    if (absl::Status status = pipeline->Start(); !status.ok()) return status;
    return pipeline;
  } catch (...) {
    return CaughtStatus();
  }
}

ReplicaPipeline::ReplicaPipeline(const PipelineOptions& options,
                                 std::unique_ptr<storage::MapStore> store,
                                 std::unique_ptr<storage::MapFollower> follower, const Clock& clock)
    : ReadingPipeline(ForReading(options), std::move(store), clock),
      follower_(std::move(follower), &parts_.map, &parts_.events, &clock, options.on_problem) {}

ReplicaPipeline::~ReplicaPipeline() { Shutdown(); }

absl::Status ReplicaPipeline::Start() {
  parts_.events.Stop();  // Drops what is noted.
  if (absl::Status status = follower_.Start(); !status.ok()) return status;
  const MapWriter::View view = parts_.map.view();
  for (const auto& [id, session] : view->sessions) {
    if (session.last_pose) at_start_[id] = session.last_pose->sequence;
  }
  absl::Status status =
      OpenParts([this](const ingest::RetentionAction&) { return CheckTakesChanges(); });
  if (!status.ok()) return status;
  StartPlacing(nullptr);
  StartComposing();
  retention_->Start();
  return absl::OkStatus();
}

absl::Status ReplicaPipeline::CheckTakesChanges() const {
  const std::string owner = follower_.state().owner;
  return absl::FailedPreconditionError(
      absl::StrCat("this server is a replica, which only reads the map: ask the server that has it",
                   owner.empty() ? "" : absl::StrCat(", ", owner)));
}

MapInfo ReplicaPipeline::GetMapInfo() {
  MapInfo info = ReadingPipeline::GetMapInfo();
  info.replica = follower_.state();
  return info;
}

ServerLoad ReplicaPipeline::GetLoad() {
  ServerLoad load = ReadingPipeline::GetLoad();
  load.replica = follower_.state();
  return load;
}

std::vector<RobotPlace> ReplicaPipeline::MappingPlaces() const {
  const MapWriter::View view = parts_.map.view();
  std::vector<RobotPlace> places;
  for (const auto& [id, first] : view->sessions) {
    if (first.record.segment > 1 || first.record.state == SessionState::kFinished) continue;
    const std::vector<const SessionView*> segments = view->SegmentsOf(id);
    const auto newest = std::find_if(segments.rbegin(), segments.rend(),
                                     [](const auto* segment) { return segment->last_pose; });
    if (newest == segments.rend()) continue;
    const SessionView& session = **newest;
    const auto before = at_start_.find(session.record.id);
    if (before != at_start_.end() && before->second == session.last_pose->sequence) continue;
    RobotPlace& place = places.emplace_back();
    place.robot = session.record.robot;
    place.session = session.record.id;
    place.stamp_ns = session.last_pose->stamp_ns;
    const Placement* placement = view->PlacementOf(place.session);
    if (placement == nullptr) continue;
    place.component = placement->component;
    place.T_map_sensor = placement->T_map_odom * session.last_pose->T_odom_sensor;
  }
  return places;
}

void ReplicaPipeline::WaitUntilIdle() {
  follower_.WaitUntilLooked();
  retention_->WaitUntilIdle();
  WaitUntilSettled();
}

void ReplicaPipeline::Shutdown() {
  if (parts_.shut_down.exchange(true)) return;
  follower_.Stop();
  if (retention_ != nullptr) retention_->Stop();
  parts_.activity.changed().Notify();
  if (placement_ != nullptr) placement_->Stop();
  if (composition_ != nullptr) composition_->Stop();
}

}  // namespace isthmus::server
