// Limits of a revision's causes, and of the event log.
#pragma once

#include <absl/time/time.h>

#include <cstddef>
#include <cstdint>

namespace isthmus::server {

// Causes of a revision that are named, so that one of a start stays a line or two; the rest is
// counted by its moves.
inline constexpr size_t kMaxCauses = 4;

// Events that wait for the store, some megabytes: a large site's in a day, so that a disk that is
// full over night costs none. Fewer, and they are lost then.
inline constexpr size_t kMaxWaitingEvents = 10'000;
// Events written at a time: a transaction of some milliseconds, which others wait for.
inline constexpr size_t kMaxEventsAtOnce = 256;
// Time after which events that could not be stored are offered again. Longer, and the log shows
// late that storing works again; shorter, and a full disk is written to all the time.
inline constexpr absl::Duration kRetryEvents = absl::Seconds(1);
// Submaps after a loop closure during which another one of the session is no event of its own. A
// guess: the way between two places that are worth telling apart. Without it a robot on its old way
// makes an event every few metres, and the log forgets people's decisions for them.
inline constexpr uint32_t kFollowingSubmaps = 5;

}  // namespace isthmus::server
