// Events: what happened at a site, and who did it, as its log keeps them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/ids.h"

namespace isthmus {

enum class EventKind {
  kUnknown,  // A kind of a newer program.
  kServerStarted,
  kServerStopped,
  kSessionOpened,
  kSessionFinished,
  kSessionDeleted,
  kSessionExpired,  // Deleted by the limits on what is stored.
  kSegmentBegun,
  kRobotLost,
  kRobotFound,
  kLocalisingBegun,  // A robot that is found in the map that others made.
  kLocalisingEnded,
  kMatchAccepted,
  kMatchLost,  // One that was accepted does not count any more.
  kLoopClosed,
  kMatchDecided,  // By a person, like the next four.
  kLoopDecided,
  kRevisionUndone,
  kAnchorSet,
  kAnchorRemoved,
  kDatumSet,  // Or removed.
  kTokenCreated,
  kTokenRevoked,
  kBackupMade,
  kStorageFailed,
  kStorageWorks,  // Again.
  kCertificateExpires,
  kEventsLost,  // As so many came at once that they could not be kept.
};

// Stable upper-case name ("ROBOT_LOST"); used in JSON, storage and messages.
const char* ToString(EventKind kind);
// kUnknown for a name that is not known.
EventKind ParseEventKind(std::string_view name);
// In the order above, without kUnknown.
const std::vector<EventKind>& AllEventKinds();

// The caller that asked for something; all empty if none did.
struct Actor {
  std::string who = {};         // The name of the token; empty where none was asked for.
  std::string from = {};        // The peer's address, as gRPC names it: "ipv4:10.0.0.7:4711".
  std::string request_id = {};  // The call's.

  bool operator==(const Actor&) const = default;
};

inline constexpr size_t kMaxEventText = 4000;  // Bytes, of each string of an event.

struct Event {
  // Given by the store: 1, 2, 3 and so on, in the order in which events were stored.
  uint64_t number = 0;
  int64_t time_ns = 0;  // Unix nanoseconds, of the server's clock.
  EventKind kind = EventKind::kUnknown;
  Actor actor = {};
  RobotId robot = {};      // Empty where it is of no robot, or of several.
  SessionId session = {};  // Empty where it is of none, or of several.
  std::string text = {};   // A sentence for a person, which says all by itself.

  bool operator==(const Event&) const = default;
};

// The part of the log that is wanted.
struct EventQuery {
  // With it the first `limit` events after that number; without, the newest `limit`.
  std::optional<uint64_t> after = {};
  int64_t since_ns = 0;               // None that happened before.
  std::vector<EventKind> kinds = {};  // Wanted kinds; empty: all.
  RobotId robot = {};                 // Only events of this robot; empty: all.
  size_t limit = 1000;
};

// Part of the log, in order of number.
struct EventPage {
  std::vector<Event> events = {};
  uint64_t after = 0;       // All that is wanted after this number, 0: or of the newest, ...
  uint64_t up_to = 0;       // ... up to this one is in here.
  uint64_t first_kept = 1;  // Older ones are gone; newest + 1 where there are none.
  uint64_t newest = 0;      // 0: nothing ever happened.
};

// True if the query asks for such events, be their numbers what they may.
bool IsWanted(const EventQuery& query, const Event& event);

}  // namespace isthmus
