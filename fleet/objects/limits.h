// The judged numbers of an object store's requests, and of objects that nothing refers to.
#pragma once

#include <absl/time/time.h>

#include <cstddef>

namespace isthmus::storage {

// Time for which an object without a reference stays. One that was just written has none until its
// transaction is committed, and a database that was set back to a moment ago refers to its objects
// of that moment: a day back.
inline constexpr absl::Duration kUnreferencedStay = absl::Hours(24);
// Between two searches for such objects, and from the start to the first: they cost a request for
// each thousand objects.
inline constexpr absl::Duration kSweepEvery = absl::Hours(6), kFirstSweep = absl::Minutes(10);

// Times of a request: to connect, to stand still, and in all: a submap of 10 MB on a link of 2
// Mbit/s.
inline constexpr long kConnectMs = 5'000, kStandsStillS = 5, kLongestRequestS = 60;
// Attempts, and the wait after the first; doubled from one to the next. Object stores ask for it
// (503) when they are busy. Writers try again by themselves.
inline constexpr int kAttempts = 2;
inline constexpr absl::Duration kFirstRetry = absl::Milliseconds(100);
// After a request that nobody answered in time others fail at once for so long: else all requests
// to a store that hangs would wait in turn, five seconds each, and a server would not end.
inline constexpr absl::Duration kTakenForAway = absl::Seconds(2);
// Bytes of an answer: more than the largest submap, and than a thousand names.
inline constexpr size_t kLargestAnswer = size_t{1} << 30;
// Connections that are kept while nobody asks.
inline constexpr size_t kIdleTransfers = 8;

}  // namespace isthmus::storage
