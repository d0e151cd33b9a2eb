#include "core/records/event.h"

#include <algorithm>

namespace isthmus {
namespace {

constexpr struct {
  EventKind kind;
  const char* name;
} kNames[] = {
    {EventKind::kServerStarted, "SERVER_STARTED"},
    {EventKind::kServerStopped, "SERVER_STOPPED"},
    {EventKind::kSessionOpened, "SESSION_OPENED"},
    {EventKind::kSessionFinished, "SESSION_FINISHED"},
    {EventKind::kSessionDeleted, "SESSION_DELETED"},
    {EventKind::kSessionExpired, "SESSION_EXPIRED"},
    {EventKind::kSegmentBegun, "SEGMENT_BEGUN"},
    {EventKind::kRobotLost, "ROBOT_LOST"},
    {EventKind::kRobotFound, "ROBOT_FOUND"},
    {EventKind::kLocalisingBegun, "LOCALISING_BEGUN"},
    {EventKind::kLocalisingEnded, "LOCALISING_ENDED"},
    {EventKind::kMatchAccepted, "MATCH_ACCEPTED"},
    {EventKind::kMatchLost, "MATCH_LOST"},
    {EventKind::kLoopClosed, "LOOP_CLOSED"},
    {EventKind::kMatchDecided, "MATCH_DECIDED"},
    {EventKind::kLoopDecided, "LOOP_DECIDED"},
    {EventKind::kRevisionUndone, "REVISION_UNDONE"},
    {EventKind::kAnchorSet, "ANCHOR_SET"},
    {EventKind::kAnchorRemoved, "ANCHOR_REMOVED"},
    {EventKind::kDatumSet, "DATUM_SET"},
    {EventKind::kTokenCreated, "TOKEN_CREATED"},
    {EventKind::kTokenRevoked, "TOKEN_REVOKED"},
    {EventKind::kBackupMade, "BACKUP_MADE"},
    {EventKind::kStorageFailed, "STORAGE_FAILED"},
    {EventKind::kStorageWorks, "STORAGE_WORKS"},
    {EventKind::kCertificateExpires, "CERTIFICATE_EXPIRES"},
    {EventKind::kEventsLost, "EVENTS_LOST"},
};

}  // namespace

const char* ToString(EventKind kind) {
  for (const auto& item : kNames) {
    if (item.kind == kind) return item.name;
  }
  return "UNKNOWN";
}

EventKind ParseEventKind(std::string_view name) {
  for (const auto& item : kNames) {
    if (item.name == name) return item.kind;
  }
  return EventKind::kUnknown;
}

const std::vector<EventKind>& AllEventKinds() {
  static const std::vector<EventKind> all = [] {
    std::vector<EventKind> kinds;
    for (const auto& item : kNames) kinds.push_back(item.kind);
    return kinds;
  }();
  return all;
}

bool IsWanted(const EventQuery& query, const Event& event) {
  const bool of_kind = query.kinds.empty() || std::find(query.kinds.begin(), query.kinds.end(),
                                                        event.kind) != query.kinds.end();
  return of_kind && event.time_ns >= query.since_ns &&
         (query.robot.empty() || query.robot == event.robot);
}

}  // namespace isthmus
