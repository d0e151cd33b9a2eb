// Limits of ingest: the end of a submap without scans, and the scans that may wait.
//
// Guesses that were never varied, except where a reason stands.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::ingest {

// Fairness.

// Scans that are this far ahead of the clock are of a recording, or of a robot that catches up: a
// live one that had no link for longer is taken for that until it has caught up. Smaller takes the
// jitter of a radio link for it.
inline constexpr int64_t kBackfillLead_ns = 2'000'000'000;
// A session that was ahead is live again when it was not for so long.
inline constexpr int64_t kMaxLead_ns = 4'000'000'000;
// Its computing time counts so many times: live robots come first, and it is not starved.
inline constexpr double kBackfillCharge = 4;
// Seconds of scans that a session with a limit on its rate may send at once: what a radio link
// holds back and then delivers. Shorter slows down robots that are within their rate.
inline constexpr double kRateBurstS = 2;
// Scans of a session that keeps the newest which may wait: one that comes next, and one in which
// the robot's own jitter is absorbed. More make poses older.
inline constexpr size_t kNewestWaiting = 2;
// Skipped scans whose acknowledgements wait for the scan at hand: more than any client has under
// way. A robot that has more waits.
inline constexpr size_t kMaxSkipped = 256;
// Points of a scan above which it is thinned to so many before the odometry sees it: more than any
// common sensor gives in a turn (OS2-128, 2048 columns: 262,144), whose scans are left alone, and
// still dealt with in a fraction of a second.
inline constexpr size_t kMaxTrackedPoints = 300'000;
// Sessions that may have all the bytes waiting that one may, at a time: by default each has 64 MiB,
// sixteen of the largest common scans.
inline constexpr size_t kSessionsAtTheirMost = 8;
// Bytes of a scan that always has room where none of its session waits: VLP-16 and OS1-64,
// compressed. Memory: so much per session beyond the limit of all.
inline constexpr size_t kSmallScanBytes = size_t{1} << 20;

// Scans.

// Scans in a row that cannot be used, after which a submap ends: the odometry bridges fewer.
inline constexpr int kBlindScans = 3;
// Lost scans in a row that are worth a line in the log; fewer come and go.
inline constexpr uint32_t kLostScans = 3;
// Finished submaps and checkpoints that may wait for the store (a full disk) before scans are
// refused: memory.
inline constexpr size_t kMaxUnpersisted = 2;
// Scans of a session whose coming is remembered until they are durable, 16 bytes each: several
// times what comes between two checkpoints. With fewer, lags are told too long by a scan or two.
inline constexpr size_t kMaxScanTimes = 1024;

// Records.

// Metres: the store rounds coordinates to a millimetre; within twice that a point that is uploaded
// again is the same.
inline constexpr float kSameCoordinateM = 0.002f;
// Bytes of a session's state, unpacked: beyond any, local maps being bounded. A record that claims
// more is damaged.
inline constexpr uint64_t kMaxStateBytes = uint64_t{1} << 30;
// Level of zstd for states: a sixth of the time that the usual level takes, for files that are a
// few per cent larger.
inline constexpr int kStateZstdLevel = 1;

}  // namespace isthmus::ingest
