// Trajectories as readers get them: the stored part and the part that is not yet, in one frame.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "core/records/map_tracks.h"
#include "server/pipeline/view_reader.h"
#include "server/placement/corrected_trajectory.h"

namespace isthmus::server {
namespace {

using Unsaved = std::map<uint32_t, std::vector<TrajectoryEntry>>;  // By segment.

// Appends the entries that are not there yet; both in order of sequence.
void Append(const std::vector<TrajectoryEntry>& newer, std::vector<TrajectoryEntry>* entries) {
  const uint64_t last = entries->empty() ? 0 : entries->back().sequence;
  for (const TrajectoryEntry& entry : newer) {
    if (entry.sequence > last) entries->push_back(entry);
  }
}

std::vector<placement::TrajectoryKnot> KnotsOf(const SharedMap<uint32_t, SubmapInfo>& submaps,
                                               const std::vector<TrajectoryEntry>& entries) {
  std::map<uint32_t, int64_t> first_stamps;  // A submap's first scan is its first keyframe.
  for (const TrajectoryEntry& entry : entries) {
    first_stamps.try_emplace(entry.submap_index, entry.stamp_ns);
  }
  std::vector<placement::TrajectoryKnot> knots;
  for (const auto& [index, submap] : submaps) {
    const auto it = first_stamps.find(index);
    const int64_t stamp_ns = it == first_stamps.end() ? submap.first_stamp_ns : it->second;
    knots.push_back({index, stamp_ns, submap.T_odom_submap});
  }
  return knots;
}

// The parts of a trajectory of one segment, all as of one moment.
struct SegmentPart {
  uint32_t segment = 1;
  SessionId session;
  SharedMap<uint32_t, SubmapInfo> submaps;
  std::vector<TrajectoryEntry> unsaved;
  std::optional<Placement> placement;
};

std::vector<SegmentPart> SegmentsOf(const MapView& view, const SessionId& opened, Unsaved unsaved) {
  std::vector<SegmentPart> parts;
  for (const SessionView* session : view.SegmentsOf(opened)) {
    SegmentPart& part = parts.emplace_back();
    part.segment = session->record.segment;
    part.session = session->record.id;
    part.submaps = session->submaps;
    part.unsaved = std::move(unsaved[part.segment]);
    if (const Placement* placed = view.PlacementOf(part.session)) part.placement = *placed;
  }
  return parts;
}

// The segments that the answer has poses of, which share its frame; notes the others as left out.
std::vector<SegmentPart> ChooseSegments(TrajectoryFrame frame, uint32_t wanted,
                                        std::vector<SegmentPart> segments,
                                        RobotTrajectory* trajectory) {
  const uint32_t last = segments.back().segment;
  std::optional<uint32_t> component;
  for (const SegmentPart& part : segments) {
    if (!part.placement || (wanted > 0 && part.segment != wanted)) continue;
    component = std::min(component.value_or(part.placement->component), part.placement->component);
  }
  if (frame == TrajectoryFrame::kMap) trajectory->component = component.value_or(0);
  const auto is_chosen = [&](const SegmentPart& part) {
    if (wanted > 0 && part.segment != wanted) return false;
    if (frame == TrajectoryFrame::kOdom) return wanted > 0 || part.segment == last;
    return part.placement && part.placement->component == component;
  };
  std::vector<SegmentPart> chosen;
  for (SegmentPart& part : segments) {
    if (is_chosen(part)) {
      chosen.push_back(std::move(part));
    } else {
      trajectory->left_out.push_back(part.segment);
    }
  }
  return chosen;
}

Trajectory OdomPoses(const std::vector<TrajectoryEntry>& entries) {
  Trajectory poses;
  for (const TrajectoryEntry& entry : entries) {
    poses.push_back({entry.stamp_ns, entry.T_odom_sensor});
  }
  return poses;
}

}  // namespace

absl::StatusOr<RobotTrajectory> ViewReader::GetTrajectory(const MapView& view, const RobotId& robot,
                                                          TrajectoryFrame frame,
                                                          uint32_t segment) const {
  RobotTrajectory trajectory;
  trajectory.revision = view.revision->revision;
  const SessionView* named = view.Named(robot);
  if (named == nullptr) return UnknownRobot(robot);
  trajectory.session = named->record.opened();
  // First what is not stored yet, then what is: what leaves the one meanwhile is in the other then.
  Unsaved unsaved;
  if (const auto worker = workers_->Find(trajectory.session).worker) {
    unsaved = worker->Status().unsaved;
  }
  std::vector<SegmentPart> segments = SegmentsOf(view, trajectory.session, std::move(unsaved));
  for (SegmentPart& part : ChooseSegments(frame, segment, std::move(segments), &trajectory)) {
    absl::StatusOr<std::vector<TrajectoryEntry>> entries = store_->GetTrajectory(part.session);
    if (!entries.ok()) return entries.status();
    Append(part.unsaved, &*entries);
    const Trajectory poses = frame == TrajectoryFrame::kOdom
                                 ? OdomPoses(*entries)
                                 : placement::CorrectTrajectory(
                                       *entries, KnotsOf(part.submaps, *entries), *part.placement);
    trajectory.parts.push_back({part.segment, poses.size()});
    trajectory.poses.insert(trajectory.poses.end(), poses.begin(), poses.end());
  }
  if (!trajectory.parts.empty()) return trajectory;
  const std::vector<uint32_t>& left_out = trajectory.left_out;
  if (segment > 0 && std::count(left_out.begin(), left_out.end(), segment) == 0) {
    return absl::NotFoundError(absl::StrCat("session ", trajectory.session.value(),
                                            " has no segment ", segment, ": the last one is ",
                                            left_out.back()));
  }
  return absl::FailedPreconditionError(absl::StrCat(
      "robot \"", robot.value(), "\" is not in the map yet: its first submap ",
      segment > 1 ? absl::StrCat("of segment ", segment, " ") : "", "is not finished"));
}

absl::StatusOr<std::vector<Track>> ViewReader::GetTracks(const MapView& view,
                                                         const MapName& map) const {
  const TrackSource source = {[&] { return Describe(view); },
                              [&] {
                                std::vector<SessionRecord> records;
                                for (const SessionView* session : view.InOrder())
                                  records.push_back(session->record);
                                return records;
                              },
                              [&](const SessionId& opened, uint32_t segment) {
                                return GetTrajectory(view, RobotId(opened.value()),
                                                     TrajectoryFrame::kMap, segment);
                              }};
  return ReadTracks(source, Describe(view), map);
}

}  // namespace isthmus::server
