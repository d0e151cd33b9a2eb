// Limits of the load generator: what a link of a kind is like, and how its own work is bounded.
//
// Guesses but for what names a reason; none of them reaches a server's map.
#pragma once

#include <cstddef>

namespace isthmus::loadgen {

// Links.

// Bytes that wait on a relay's way before no more are read: what a radio's queue holds. Less would
// slow links that are long and fast, more would hide their rate from the sender.
inline constexpr size_t kMaxRelayed = size_t{512} << 10;
// Milliseconds a relay sleeps at most while something waits for its time: the resolution of delays.
inline constexpr int kRelayTickMs = 1;

// Robots.

// Seconds by which robots on one drive follow each other, so that no two send the same scan.
inline constexpr double kFollowS = 7;
// Different drives at most: memory, about 0.7 MB a second of a VLP-16's.
inline constexpr int kMaxDrives = 4;
// Step to which coordinates are rounded on the wire, as `isthmus push` does, metres.
inline constexpr double kResolutionM = 0.002;
// Attempts of a robot at a link that does not come back, a minute or two, as `isthmus push`.
inline constexpr int kAttempts = 32;
// The same at the start, before anything is sent: a person waits.
inline constexpr int kFirstAttempts = 3;

// Readers.

// Metres around a robot that a reader asks for.
inline constexpr double kReaderRadiusM = 30;
// Seconds after which a reader gives up on an answer.
inline constexpr double kReaderTimeoutS = 20;

// Misbehaving clients.

// Seconds from one sign of life of a misbehaving client to the next.
inline constexpr double kMisbehavingPeriodS = 1;
// Bytes of a malformed message at most: about what a small scan takes.
inline constexpr size_t kNoiseBytes = 20'000;
// Seconds after which a malformed stream counts as not answered.
inline constexpr double kNoiseTimeoutS = 5;

}  // namespace isthmus::loadgen
