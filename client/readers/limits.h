// Limits by which recordings are read.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::readers {

// Errors that are read over in search of a first scan, before a recording is taken to tell nothing
// of its sensor. A guess; all are kept.
inline constexpr size_t kErrorsReadAhead = 100;

// Nanoseconds since the Unix epoch, the year 2115: stamps beyond are none. The difference of any
// two is an int64, and the sum.
inline constexpr int64_t kLatestStampNs = 4'600'000'000'000'000'000;
// Seconds from which on a clock of points is that of Unix time: 2001. Since when a sensor or a
// robot was switched on is less.
inline constexpr double kUnixTimeS = 1e9;
// Nanoseconds by which the clock in a scan's points and that of its header may differ to be taken
// for one: a scan and its transport take less, clocks that were never set differ by years.
inline constexpr int64_t kSameClockNs = 10'000'000'000;
// Scans among which one that comes twice is known again: two recorders of one topic are late by
// less than a scan or two. A guess.
inline constexpr size_t kDistinctScans = 4;
// Names of files (name_series.h, name_times.h).

// Share of the steps between numbers that are the usual one where a series counts steadily: what is
// missing are gaps. Keyframes are picked with steps of all kinds. A guess.
inline constexpr double kSteadyShare = 0.75;
// Nanoseconds between names, mostly, for numbers to be times: no LiDAR gives 100 scans a second.
inline constexpr int64_t kShortestIntervalNs = 8'000'000;
// Nanoseconds by which whole numbers without a year go up where they are nano- or microseconds:
// from 100 scans a second to one in two seconds. In these units numbers go up by 5,000 or more,
// which nobody counts in; the two ranges, a factor of 1,000 apart, do not meet.
inline constexpr int64_t kLeastStepNs = 10'000'000, kMostStepNs = 2'000'000'000;

// Bytes of a line of a trajectory: 12 numbers of 24 letters. Longer ones are none.
inline constexpr size_t kMostPoseLine = 300;
// Names that are given where files are left out; the others are counted.
inline constexpr size_t kNamesGiven = 5;

// Scans that are looked at for the number of rings. The first may miss the outermost.
inline constexpr size_t kRingScans = 5;
// Rings above which no sensor is known.
inline constexpr double kMaxKnownRings = 128;

}  // namespace isthmus::readers
