// The map as of one moment: an immutable value that any number of threads read without a lock.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/map/composed_map.h"
#include "core/map/match.h"
#include "core/map/revision.h"
#include "server/match_graph/match_graph.h"
#include "server/placement/placer.h"
#include "storage/map_records.h"

namespace isthmus::server {

using storage::SessionPair;
using SessionView = storage::SessionRecords;

// All that one answer says comes from one view, so it is of one revision. An old view lives as long
// as somebody reads it; parts that did not change since are shared with the newer ones.
struct MapView : storage::MapRecords {
  uint64_t serial = 0;         // Grows with every edit.
  uint64_t graph_version = 0;  // Grows with everything that placements rest on.
  uint64_t removals = 0;       // Sessions that were removed since the server started.
  uint64_t retired = 0;        // Submaps that were retired since then.

  // Matches as the graph is made of them, in order of the pairs: computed ones under people's
  // decisions, set aside where others speak against them, and accepted where others settle them.
  // Never null, like all that follow.
  std::shared_ptr<const std::vector<Match>> effective =
      std::make_shared<const std::vector<Match>>();

  // The result of placing the state at placed_version.
  uint64_t placed_version = 0;
  std::shared_ptr<const MapRevision> revision = std::make_shared<const MapRevision>();
  std::shared_ptr<const std::vector<SessionPair>> tree =
      std::make_shared<const std::vector<SessionPair>>();
  // The edges that `revision` agrees with.
  std::shared_ptr<const placement::EdgeStatus> edge_status =
      std::make_shared<const placement::EdgeStatus>();

  // The newest composed map, null before the first, and the last revision of which one was made
  // with no submaps waiting.
  std::shared_ptr<const ComposedMap> map;
  int64_t composed_revision = -1;

  // Nothing has changed that `revision` does not show.
  bool IsPlaced() const { return placed_version == graph_version; }
  // `map` shows all of `revision`.
  bool IsComposed() const { return composed_revision == revision->revision; }

  // Pointers into the view; null where there is none.
  const SessionView* Find(const SessionId& session) const { return sessions.Find(session); }
  // The robot's newest session, where that has several segments the last.
  const SessionView* Newest(const RobotId& robot) const;
  // The session of that id, or else the newest of the robot of that name: whoever calls a robot
  // like another's session hides nothing.
  const SessionView* Named(const RobotId& robot_or_session) const;
  const Placement* PlacementOf(const SessionId& session) const;
  // The component that is meant, as of `revision`. NotFound where there is none.
  absl::StatusOr<uint32_t> NumberOf(const MapName& name) const;
  const Match* EffectiveMatch(const SessionPair& pair) const;
  // The segments of the session that a robot opened, in order; none for another id.
  std::vector<const SessionView*> SegmentsOf(const SessionId& opened) const;
  // All in order of creation, the segments of a session after each other.
  std::vector<const SessionView*> InOrder() const;

  // All submaps with their placements, for composition.
  std::vector<PlacedSubmap> PlacedSubmaps() const;
};

// The sessions that have submaps.
std::vector<match_graph::Node> MatchGraphNodes(const MapView& view);

// The input of the pose graph.
placement::Input PlacementInput(const MapView& view);

}  // namespace isthmus::server
