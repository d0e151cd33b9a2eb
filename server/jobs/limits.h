// Limits of matching as a job: of maps kept ready for it, and of jobs handed out.
//
// Guesses that were never varied, except where a reason stands; none of them changes a map, all
// change when it is there.
#pragma once

#include <absl/time/time.h>

#include <cstddef>
#include <cstdint>

namespace isthmus::server {

// Nice value of matching threads, which give way to the taking of scans: at 10 a thread gets a
// tenth of what a thread at 0 gets of a core that both want. More, and matches of a server at its
// limit never come; less, and robots wait for them.
inline constexpr int kMatchingNice = 10;

// Maps that are kept ready at most: the robots of a team. Memory, about a megabyte per submap.
inline constexpr size_t kMaxPreparedMaps = 8;
// Sessions whose submaps stay prepared for the search for loops, LoopOptions::prepared_submaps of
// each, for robots that drive at one time: memory; others are read again.
inline constexpr size_t kMaxKeptFinders = 16;
// Bytes of a prepared submap as stored: kMaxViews of 33 kB, and more points than a submap has. A
// record that claims more is not read.
inline constexpr uint64_t kMaxPreparedBytes = uint64_t{1} << 28;

// Submaps that wait for the server's own search for loops, 0.2 s each, before it gives any to
// workers: with these a loop is up to a second later in the map, and ten where they are at pairs.
inline constexpr uint64_t kLoopsAtHome = 8;
// Jobs in the queue at a time: some for each of a dozen workers, so that none waits for the next
// one, and few enough that a posted job is new when it is taken. Beyond that pairs wait; searches
// for loops, which come before them, do beyond twice as many.
inline constexpr size_t kMaxPostedJobs = 32;
// Time between two looks for results of workers, and for workers. The first is the delay of a match
// in the map; the question takes less than a millisecond.
inline constexpr double kLookForResultsMs = 200, kLookForWorkersMs = 2000;
inline constexpr absl::Duration kLookForWorkersIdle = absl::Seconds(5);
// Milliseconds after which a search for loops that no worker has begun is taken back, and for which
// the server then does all of them itself: the next place waits for it, and workers may be at pairs
// for half a minute each.
inline constexpr double kLoopsUntakenMs = 1000, kLoopsAtHomeMs = 15'000;

}  // namespace isthmus::server
