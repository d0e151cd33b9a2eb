#include "tests/server/rpc/fake_pipeline.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <gtest/gtest.h>

#include <utility>

#include "core/formats/octomap_reader.h"
#include "core/records/map_tracks.h"

namespace isthmus::rpc {

absl::StatusOr<DecidedLoop> FakeDecisions::DecideLoop(const LoopDecision& decision,
                                                      const Actor& by) {
  actors.push_back(by);
  loop_decisions.push_back(decision);
  return decided_loop;
}

absl::StatusOr<int64_t> FakeDecisions::PutAnchor(Anchor anchor, const Actor& by) {
  actors.push_back(by);
  anchors.push_back(std::move(anchor));
  return anchored;
}

absl::StatusOr<int64_t> FakeDecisions::UndoRevision(int64_t revision, const std::string& note,
                                                    const Actor& by) {
  actors.push_back(by);
  undone.emplace_back(revision, note);
  return undo;
}

uint64_t FakeMap::point_count(uint32_t component) const {
  return component == 0 ? points_.size() : 0;
}

Box FakeMap::bounds(uint32_t) const {
  Box box;
  for (const MapPoint& point : points_) box.Extend(Eigen::Vector3d(point.x, point.y, point.z));
  return box;
}

absl::Status FakeMap::Read(const Region& region, size_t chunk, const Emit& emit) const {
  std::vector<MapPoint> found;
  uint64_t skipped = 0;
  for (const MapPoint& point : points_) {
    const Eigen::Vector3d p(point.x, point.y, point.z);
    if (region.component != 0) continue;
    if (!region.box.empty() && !region.box.Contains(p)) continue;
    if (region.has_sphere && (p - region.center).norm() > region.radius_m) continue;
    if (region.robot >= 0 && point.robot != static_cast<uint32_t>(region.robot)) continue;
    if (region.shape != nullptr && !region.shape->Contains(p)) continue;
    if (point.stamp < region.seen_from || point.stamp > region.seen_to) continue;
    if (!region.classes.Has(point.label)) continue;
    if (region.keep && !region.keep(point)) continue;
    if (skipped < region.skip) {
      ++skipped;
      continue;
    }
    found.push_back(point);
    if (found.size() < chunk) continue;
    if (!emit(found)) return absl::OkStatus();
    found.clear();
  }
  if (!found.empty()) emit(found);
  return read_;
}

absl::StatusOr<ListAt<SubmapStatus>> FakeReader::ListSubmaps(
    const std::optional<RobotId>& robot) const {
  MutexLock lock(&mutex_);
  ListAt<SubmapStatus> list;
  list.revision = info.revision;
  for (const Submap& submap : submaps_) {
    if (robot && submap.robot != *robot) continue;
    SubmapStatus status{Summarize(submap), std::nullopt, Pose()};
    if (const auto found = placed.find(ToString(submap.id)); found != placed.end()) {
      status.component = 1;
      status.T_map_submap = found->second;
    }
    list.push_back(std::move(status));
  }
  if (robot && list.empty()) return absl::NotFoundError("no such robot");
  return list;
}

absl::StatusOr<ListAt<Loop>> FakeReader::ListLoops(const std::optional<RobotId>& robot) const {
  asked_robot = robot;
  if (!loops.ok()) return loops.status();
  ListAt<Loop> list{*loops};
  list.revision = info.revision;
  return list;
}

std::shared_ptr<const server::MapView> FakeReader::View() const {
  auto view = std::make_shared<server::MapView>();
  view->map = map;
  {
    MutexLock lock(&mutex_);
    for (const auto& [id, session] : sessions_) {
      server::SessionView records;
      records.record = session.status.record;
      for (const Submap& submap : submaps_) {
        if (submap.id.session != id) continue;
        records.submaps.Set(submap.id.index, std::make_shared<const SubmapInfo>(Summarize(submap)));
      }
      view->sessions.Set(id, std::make_shared<const server::SessionView>(std::move(records)));
    }
  }
  auto revision = std::make_shared<MapRevision>();
  MutexLock lock(&load_mutex);
  revision->revision = load.revision;
  view->composed_revision = load.composition_waits ? -1 : load.revision;
  view->revision = std::move(revision);
  return view;
}

ListAt<RobotAnchor> FakeReader::ListAnchors(const server::MapView&) const {
  MutexLock lock(&mutex_);
  ListAt<RobotAnchor> list;
  list.revision = info.revision;
  for (const Anchor& anchor : anchors) {
    const auto found = sessions_.find(anchor.submap.session);
    list.push_back(
        {anchor, found == sessions_.end() ? RobotId() : found->second.status.record.robot});
  }
  return list;
}

absl::StatusOr<std::vector<Track>> FakeReader::GetTracks(const server::MapView& view,
                                                         const MapName& map_name) const {
  const TrackSource source = {[&] { return info; },
                              [&] {
                                MutexLock lock(&mutex_);
                                std::vector<SessionRecord> records;
                                for (const auto& [id, session] : sessions_)
                                  records.push_back(session.status.record);
                                return records;
                              },
                              [&](const SessionId& opened, uint32_t segment) {
                                return GetTrajectory(view, RobotId(opened.value()),
                                                     TrajectoryFrame::kMap, segment);
                              }};
  return ReadTracks(source, info, map_name);
}

absl::StatusOr<FreeSpace> FakeReader::ReadFreeSpace(const server::MapView&,
                                                    const ExportRequest& wanted,
                                                    uint64_t max_file_bytes,
                                                    const std::function<bool()>&) const {
  exports.push_back(wanted);
  const std::string bytes = absl::StrJoin(file, "");
  if (bytes.size() > max_file_bytes) return absl::ResourceExhaustedError("too large");
  FreeSpace space;
  const auto resolution_m = formats::ParseOctomapBinary(
      bytes, [&space](const VoxelCube& cube) { space.cubes.push_back(cube); });
  if (!resolution_m.ok()) return resolution_m.status();
  space.resolution_m = *resolution_m;
  return space;
}

absl::StatusOr<RobotTrajectory> FakeReader::GetTrajectory(const server::MapView&, const RobotId&,
                                                          TrajectoryFrame, uint32_t segment) const {
  trajectory_segment = segment;
  absl::StatusOr<RobotTrajectory> answer = trajectory;
  if (answer.ok() && answer->parts.empty()) answer->parts = {{1, answer->poses.size()}};
  return answer;
}

absl::StatusOr<RobotTransform> FakeReader::GetTransform(const RobotId&, const RobotId&) const {
  return transform;
}

absl::Status FakeReader::ExportMap(const ExportRequest& request,
                                   const std::function<void(int64_t)>& begin,
                                   const std::function<bool(const std::string&)>& sink) const {
  exports.push_back(request);
  begin(map->revision());
  for (const std::string& piece : file) {
    if (!sink(piece)) return absl::CancelledError("the reader went away");
  }
  return export_status;
}

void FakeEvents::NoteAll(const std::vector<Event>& events) {
  EXPECT_TRUE(log_->Write({.events = events}).ok());
  wakes_.Tell();
}

std::optional<MapStep> FakeFeed::Since(const MapMark& known, uint32_t) {
  MutexLock lock(&mutex_);
  if (steps_.empty()) return std::nullopt;
  MapStep step = steps_.back();
  step.restart = known.run != step.mark.run;
  if (known.revision == step.mark.revision && !step.restart) {
    MapStep none;
    none.mark = step.mark;
    return none;
  }
  return step;
}

void FakeFeed::ShowStep(MapStep step) {
  {
    MutexLock lock(&mutex_);
    steps_.push_back(std::move(step));
  }
  wakes_.Tell();
}

std::vector<RobotPlace> FakePipeline::RobotPlaces() {
  MutexLock lock(&places_mutex_);
  return places_;
}

void FakePipeline::PutRobots(std::vector<RobotPlace> places) {
  MutexLock lock(&places_mutex_);
  places_ = std::move(places);
}

}  // namespace isthmus::rpc
