#include "server/map/edit_events.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "server/map/limits.h"
#include "server/map/map_writer.h"

namespace isthmus::server {
namespace {

std::string Noted(const std::string& note) {
  return note.empty() ? "" : absl::StrCat("; note: ", note);
}

RobotId RobotOf(const SessionId& session, const MapView& view) {
  const SessionView* known = view.Find(session);
  return known == nullptr ? RobotId() : known->record.robot;
}

Event Make(EventKind kind, const Actor& by, std::string text) {
  Event event;
  event.kind = kind;
  event.actor = by;
  event.text = std::move(text);
  return event;
}

std::string MatchName(const SessionId& a, const SessionId& b) {
  return absl::StrCat("match ", a.value(), " ~ ", b.value());
}

bool IsAccepted(const Match& match) { return match.state == MatchState::kAccepted; }

// Sets of sessions that matches connect.
class Connected {
 public:
  void Join(const SessionId& a, const SessionId& b) { parents_[RootOf(a)] = RootOf(b); }
  bool Are(const SessionId& a, const SessionId& b) { return RootOf(a) == RootOf(b); }

 private:
  SessionId RootOf(SessionId id) {
    while (true) {
      const auto [item, is_new] = parents_.try_emplace(id, id);
      if (is_new || item->second == id) return id;
      id = item->second;
    }
  }
  std::map<SessionId, SessionId> parents_;
};

const Match* Find(const std::vector<Match>& matches, const Match& wanted) {
  const auto is_less = [](const Match& a, const Match& b) {
    return std::pair(a.a, a.b) < std::pair(b.a, b.b);
  };
  const auto found = std::lower_bound(matches.begin(), matches.end(), wanted, is_less);
  if (found == matches.end() || found->a != wanted.a || found->b != wanted.b) return nullptr;
  return &*found;
}

}  // namespace

Event SessionEvent(EventKind kind, const SessionRecord& record, const Actor& by,
                   const std::string& more) {
  const char* verb = kind == EventKind::kSessionOpened     ? "opened"
                     : kind == EventKind::kSessionFinished ? "finished"
                                                           : "deleted";
  Event event = Make(kind, by,
                     absl::StrCat("session ", record.id.value(), " of ", record.robot.value(), " ",
                                  verb, more.empty() ? "" : ": ", more));
  event.robot = record.robot;
  event.session = record.id;
  return event;
}

std::vector<Event> DecisionEvents(const ManualEdit& edit, const MapView& view) {
  std::vector<Event> events;
  if (edit.undone) {
    events.push_back(Make(EventKind::kRevisionUndone, edit.by,
                          absl::StrCat("revision ", *edit.undone, " undone", Noted(edit.note))));
  }
  for (const ManualDecision& decision : edit.manual_decisions) {
    events.push_back(Make(EventKind::kMatchDecided, edit.by,
                          absl::StrCat(MatchName(decision.a, decision.b), " by hand: ",
                                       ToString(decision.kind), Noted(decision.note))));
    events.back().session = decision.a;
  }
  for (const SessionPair& pair : edit.withdrawn) {
    events.push_back(Make(EventKind::kMatchDecided, edit.by,
                          absl::StrCat(MatchName(pair.first, pair.second),
                                       ": decision by hand withdrawn", Noted(edit.note))));
    events.back().session = pair.first;
  }
  for (const LoopClosure& loop : edit.loops) {
    events.push_back(Make(EventKind::kLoopDecided, edit.by,
                          absl::StrCat("loop ", loop.id, " by hand: ",
                                       loop.rejected ? "REJECT" : "RESTORE", Noted(loop.note))));
    events.back().session = loop.session;
    events.back().robot = RobotOf(loop.session, view);
  }
  return events;
}

Event AnchorEvent(EventKind kind, const SubmapId& submap, const Actor& by, const std::string& note,
                  const MapView& view) {
  Event event =
      Make(kind, by,
           absl::StrCat("anchor of submap ", ToString(submap),
                        kind == EventKind::kAnchorSet ? " set" : " removed", Noted(note)));
  event.session = submap.session;
  event.robot = RobotOf(submap.session, view);
  return event;
}

Event DatumEvent(const std::optional<Datum>& datum, const Actor& by) {
  if (!datum) return Make(EventKind::kDatumSet, by, "datum removed");
  return Make(
      EventKind::kDatumSet, by,
      absl::StrFormat("datum set to %.8f, %.8f, %.3f m, heading %.4f deg", datum->latitude_deg,
                      datum->longitude_deg, datum->altitude_m, datum->heading_deg));
}

std::vector<Event> LoopEvents(const std::vector<LoopClosure>& found, const MapView& view) {
  std::vector<Event> events;
  std::map<SessionId, uint32_t> newest;  // By session: the newest submap seen on an older one.
  for (const auto& [id, loop] : view.loops) {
    uint32_t& index = newest[loop.session];
    index = std::max(index, loop.submap_b);
  }
  for (const LoopClosure& loop : found) {
    const auto [before, is_first] = newest.try_emplace(loop.session, loop.submap_b);
    const bool follows = !is_first && loop.submap_b <= before->second + kFollowingSubmaps;
    before->second = std::max(before->second, loop.submap_b);
    if (follows) continue;
    Event& event = events.emplace_back(Make(
        EventKind::kLoopClosed, {},
        absl::StrCat("loop ", loop.id, ": submap ", ToString(SubmapId{loop.session, loop.submap_b}),
                     " lies on submap ", loop.submap_a)));
    event.session = loop.session;
    event.robot = RobotOf(loop.session, view);
  }
  return events;
}

std::vector<Event> MatchEvents(const std::vector<Match>& before, const std::vector<Match>& after,
                               const MapView& now) {
  std::vector<Event> events;
  Connected connected;
  for (const Match& match : before) {
    if (!IsAccepted(match)) continue;
    connected.Join(match.a, match.b);
    const Match* present = Find(after, match);
    if (present != nullptr && IsAccepted(*present)) continue;
    if (now.Find(match.a) == nullptr || now.Find(match.b) == nullptr) continue;
    const std::string why =
        present == nullptr || present->detail.empty() ? "" : absl::StrCat(": ", present->detail);
    events.push_back(
        Make(EventKind::kMatchLost, {},
             absl::StrCat(MatchName(match.a, match.b), " does not count any more", why)));
    events.back().session = match.a;
  }
  for (const Match& match : after) {
    if (!IsAccepted(match)) continue;
    const Match* past = Find(before, match);
    if (past != nullptr && IsAccepted(*past)) continue;
    const bool joins = !connected.Are(match.a, match.b);
    connected.Join(match.a, match.b);
    events.push_back(Make(EventKind::kMatchAccepted, {},
                          absl::StrCat(MatchName(match.a, match.b), " accepted",
                                       joins ? ", which joins their maps" : "")));
    events.back().session = match.a;
  }
  return events;
}

}  // namespace isthmus::server
