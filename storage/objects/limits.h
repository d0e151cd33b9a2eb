// The judged numbers of values in an object store.
#pragma once

#include <absl/time/time.h>

#include <cstddef>

namespace isthmus::storage {

// Values below so many bytes stay in the database: a request to an object store costs as much as
// storing them there for years, and takes longer than a commit.
inline constexpr size_t kSmallestObject = 16'384;

// Time for which an object without a reference stays. One that was just written has none until its
// transaction is committed, and a database that was set back to a moment ago refers to its objects
// of that moment: a day back.
inline constexpr absl::Duration kUnreferencedStay = absl::Hours(24);
// Time for which the same value is the same object, and number of such values that are known: while
// a database is away its writers try to commit again and again. Far less than kUnreferencedStay, as
// the object may be unreferenced all that time.
inline constexpr absl::Duration kSameObject = absl::Hours(1);
inline constexpr size_t kKnownObjects = 256;
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
// Times that an object is read before it is taken for damaged: a proxy may answer for the object
// store.
inline constexpr int kReadings = 3;
// Bytes of an answer: more than the largest submap, and than a thousand names.
inline constexpr size_t kLargestAnswer = size_t{1} << 30;
// Connections that are kept while nobody asks.
inline constexpr size_t kIdleTransfers = 8;

}  // namespace isthmus::storage
