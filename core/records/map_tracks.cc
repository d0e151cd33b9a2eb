#include "core/records/map_tracks.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

namespace isthmus {
namespace {

constexpr int kAttempts = 5;  // Maps join and part once in minutes.

bool Has(const std::vector<SessionId>& sessions, const SessionId& session) {
  return std::ranges::find(sessions, session) != sessions.end();
}

// The component asked for, as it was at one revision: none if there are no maps.
Component ComponentOf(const MapInfo& info, uint32_t number) {
  return number < info.components.size() ? info.components[number] : Component();
}

// The map has the frame that it had, and no less in it.
bool Holds(const Component& before, const MapInfo& now) {
  if (before.sessions.empty()) return now.components.empty();
  const auto same = std::ranges::find(now.components, before.reference, &Component::reference);
  return same != now.components.end() && std::ranges::all_of(before.sessions, [&](const auto& id) {
           return Has(same->sessions, id);
         });
}

// The sessions of the robot, or of all where it is empty. NotFound where it has none;
// FailedPrecondition, naming its map, where these lie in other maps alone.
absl::StatusOr<std::vector<SessionRecord>> SessionsOf(const TrackSource& source,
                                                      const MapInfo& info, uint32_t number,
                                                      const RobotId& robot) {
  auto sessions = source.sessions();
  if (!sessions.ok() || robot.empty()) return sessions;
  std::erase_if(*sessions, [&](const SessionRecord& session) { return session.robot != robot; });
  if (sessions->empty()) {
    return absl::NotFoundError(absl::StrCat("no robot \"", robot.value(), "\" in this map"));
  }
  std::vector<SessionId> ids;
  for (const SessionRecord& session : *sessions) ids.push_back(session.id);
  const absl::Status is_here = CheckRobotIsIn(
      number, robot, ids, [&info](const SessionId& session) { return MapWith(info, session); });
  if (!is_here.ok()) return is_here;
  return sessions;
}

// The tracks as one round of questions gives them; `revisions` gets those of the answers.
absl::StatusOr<std::vector<Track>> AskOnce(const TrackSource& source, const MapInfo& info,
                                           uint32_t number, const RobotId& robot,
                                           std::vector<int64_t>& revisions) {
  const auto sessions = SessionsOf(source, info, number, robot);
  if (!sessions.ok()) return sessions.status();
  const Component component = ComponentOf(info, number);
  std::vector<Track> tracks;
  for (const SessionRecord& session : *sessions) {
    if (!Has(component.sessions, session.id)) continue;
    auto way = source.trajectory(session.opened(), std::max(session.segment, 1u));
    // It left the map, or was deleted, meanwhile.
    if (absl::IsFailedPrecondition(way.status()) || absl::IsNotFound(way.status())) continue;
    if (!way.ok()) return way.status();
    revisions.push_back(way->revision);
    if (tracks.empty() || tracks.back().session != session.opened()) {
      tracks.push_back({session.robot, session.opened(), {}});
    }
    Trajectory& poses = tracks.back().poses;
    poses.insert(poses.end(), way->poses.begin(), way->poses.end());
  }
  return tracks;
}

}  // namespace

absl::StatusOr<MapName> StableName(const MapInfo& info, const MapName& map) {
  const auto number = NumberIn(info, map);
  if (!number.ok()) return number.status();
  const Component component = ComponentOf(info, *number);
  return component.reference.empty() ? map : MapName(component.reference);
}

absl::StatusOr<std::vector<Track>> ReadTracks(const TrackSource& source, MapInfo info,
                                              const MapName& map, const RobotId& robot) {
  const auto name = StableName(info, map);
  if (!name.ok()) return name.status();
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto number = NumberIn(info, *name);
    if (!number.ok()) return number.status();
    const Component component = ComponentOf(info, *number);
    std::vector<int64_t> revisions;
    auto tracks = AskOnce(source, info, *number, robot, revisions);
    if (!tracks.ok()) return tracks.status();
    if (std::ranges::all_of(revisions, [&](int64_t r) { return r == info.revision; })) {
      return tracks;
    }
    auto now = source.map_info();
    if (!now.ok()) return now.status();
    if (Holds(component, *now)) return tracks;
    info = *std::move(now);
  }
  return absl::AbortedError("maps join and part faster than their ways can be read: ask again");
}

std::vector<Trajectory> NewestWays(std::vector<Track> tracks, const std::vector<RobotId>& robots) {
  std::vector<Trajectory> ways(robots.size());
  for (Track& track : tracks) {
    const auto robot = std::ranges::find(robots, track.robot);
    if (robot != robots.end()) ways[robot - robots.begin()] = std::move(track.poses);
  }
  return ways;
}

}  // namespace isthmus
