// Limits of ingest: which stamps are believed, when a submap ends without scans, what may wait.
//
// Guesses that were never varied, but for what names a reason.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::ingest {

// Clocks, nanoseconds.

// A stamp up to this much before the last one is of a scan out of order or sent twice; farther back
// it is of a clock that was set. Smaller takes late scans for clocks.
inline constexpr int64_t kOutOfOrder_ns = 1'000'000'000;
// A pause of a minute or of a year is the same to the odometry: no step is longer.
inline constexpr int64_t kMaxStep_ns = 10'000'000'000;
// Scans this far apart still give the interval by which a clock that was set goes on; longer ones
// are pauses. Spinning sensors take 50 to 200 ms.
inline constexpr int64_t kMaxInterval_ns = 600'000'000;

// Scans.

// Scans in a row that cannot be used, after which a submap ends: the odometry bridges fewer.
inline constexpr int kBlindScans = 3;
// Lost scans in a row that are worth a line in the log; fewer come and go.
inline constexpr uint32_t kLostScans = 3;
// Finished submaps and checkpoints that may wait for the store (a full disk) before scans are
// refused: memory.
inline constexpr size_t kMaxUnpersisted = 2;

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
