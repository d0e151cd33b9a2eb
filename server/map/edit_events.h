// The events that edits of the map make, in words.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/map/datum.h"
#include "core/map/loop_closure.h"
#include "core/map/match.h"
#include "core/records/event.h"
#include "server/map/map_view.h"

namespace isthmus::server {

struct ManualEdit;

// All without a time. `more`, if any, is said behind a colon.
Event SessionEvent(EventKind kind, const SessionRecord& record, const Actor& by,
                   const std::string& more = "");
// The events of a decision, by edit.by: the undoing first, if it is one.
std::vector<Event> DecisionEvents(const ManualEdit& edit, const MapView& view);
Event AnchorEvent(EventKind kind, const SubmapId& submap, const Actor& by, const std::string& note,
                  const MapView& view);
Event DatumEvent(const std::optional<Datum>& datum, const Actor& by);

// The events of new loop closures. A robot that follows its old way closes a loop with every
// submap: a loop within kFollowingSubmaps of the one before is no event.
std::vector<Event> LoopEvents(const std::vector<LoopClosure>& found, const MapView& view);

// The pairs that are accepted in one list of effective matches and not in the other, as long as
// both sessions are there. Both lists are in order of pair.
std::vector<Event> MatchEvents(const std::vector<Match>& before, const std::vector<Match>& after,
                               const MapView& now);

}  // namespace isthmus::server
