// Limits of the server's threads: how often they try, and what they keep.
//
// Guesses that were never varied, but for what names a reason; none of them changes a map, all
// change when it is there.
#pragma once

#include <absl/time/time.h>

#include <cstddef>
#include <cstdint>

#include "server/matching/prepared/limits.h"

namespace isthmus::server {

// Niceness, as kMatchingNice: placement gives way least, as it is short and all others wait for it.
inline constexpr int kCompositionNice = 8, kPlacementNice = 5;

// Between two looks of a server that only reads for what is new in the store: a question of less
// than a millisecond. On average half of it goes by until a new revision is seen.
inline constexpr absl::Duration kFollowInterval = absl::Milliseconds(200);

// The server tries once a second to store what waits, each time for up to ten seconds where its
// bucket hangs: what is large and fails is tried again before this, if it is wanted still.
inline constexpr absl::Duration kLargeTried = absl::Seconds(20);

// Matching.

// With more sessions than kMaxPreparedMaps share by which one of a pair has to grow before it is
// tried again: a robot among the maps of a month is not matched with all of them at every submap.
inline constexpr double kSeldomGrowth = matching::kNewMapGrowth - 1;
// Points of a session's map, all submaps together, below which it is matched with no other: with
// fewer than this no match was ever found, and a hundred such sessions make 4,950 pairs.
inline constexpr uint64_t kLeastMatchedPoints = 100;
// Submaps that a session has, or it is finished, before its partners are chosen, and growth after
// which they are chosen anew: of fewer, partners are chosen by chance; more often takes time.
inline constexpr uint32_t kMinIndexedSubmaps = 3;
inline constexpr double kIndexedGrowth = 1.5;
// Metres between the ways of sessions in one frame, up to which they may have seen the same: as far
// as two sensors look, and a GNSS receiver among houses errs.
inline constexpr double kNearSessionsM = 50;
// Time that matching waits, each time, for a store on a disk that does not give a submap, which is
// left out then; and time between two looks. A remote store is waited for until it is back, so that
// no match is made of a part of a map, and any store while it cannot write.
inline constexpr double kStoreAwayMs = 12'000;
inline constexpr absl::Duration kStoreAwayLook = absl::Milliseconds(100);
// Probability below which an accepted match is given up. A guess: between a half, the most that is
// left of twins without anchors, and a moment of doubt.
inline constexpr double kGivenUpBelow = 0.7;
// Ends of the server at the same piece of work, after which it is left out and named: one may have
// been anybody's doing.
inline constexpr int kMaxCrashes = 2;
// Time after the start for which such work is left out: then it is tried once more, as whoever
// killed the server may be to blame. Doubled by each further end, so that work that does crash it
// costs a crash in ten minutes, then in twenty, and sound maps are kept apart for a day at most.
inline constexpr absl::Duration kLeftOutAfterCrashes = absl::Minutes(10);
inline constexpr absl::Duration kLeftOutAtMost = absl::Hours(24);
// Interval between looks whether that is over.
inline constexpr absl::Duration kLookForLeftOut = absl::Seconds(1);

// Composition.

// Points of new submaps that are composed in one turn, seconds of work; what exceeds them waits for
// others. A robot's submap has 20,000 to 300,000: more would put robots off that come together,
// less would make many maps of one that is uploaded whole.
inline constexpr uint64_t kTurnPoints = 1'000'000;

// Rest after a composition, in times of what it took, up to composition.interval_s: a small map is
// there in no time, a large one takes a fifth of a core at most while it changes.
inline constexpr double kRestPerWork = 4;
// Interval at which the map is saved for the next start. A kill costs composing what came since, a
// second for about six submaps; more often would write an active robot's tiles, some megabytes,
// again and again.
inline constexpr absl::Duration kSaveMapEvery = absl::Minutes(5);
// Seconds until a composition that failed is tried again; milliseconds since being told to stop in
// which the last map may still be composed.
inline constexpr double kComposeAgainS = 3, kLastMapMs = 1000;
// Failures of a submap after which it is left out: memory may have been short for a moment.
inline constexpr int kMaxFailures = 2;

// Storing.

// Seconds between attempts to store what waits: a full disk is noticed to be free within one.
inline constexpr double kRetryStoreS = 1;
// Ages of what is stored are looked at this often; what is due is dropped a minute late at most.
inline constexpr absl::Duration kRetentionInterval = absl::Minutes(1);
// Rounds of dropping. What is dropped makes room for no other round to drop more: two suffice, and
// a store that cannot delete is not asked for ever.
inline constexpr int kMaxRetentionRounds = 3;

}  // namespace isthmus::server
