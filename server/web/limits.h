// Judged limits of the service to browsers.
#pragma once

#include <chrono>
#include <cstddef>

namespace isthmus::web {

// Connections at a time, a thread of some hundred kB each; a browser opens six. Half of them from
// one address at most, so that no machine keeps the others out.
inline constexpr size_t kConnections = 256, kConnectionsPerAddress = 128;

// Answers that come as a stream, exports included, at a time; a page has two open. Beyond, 503. So
// many connections at least are left for everything else.
inline constexpr size_t kWebStreams = 96;

// Such streams to one address, so that nobody takes all: some twenty pages behind one proxy.
inline constexpr size_t kWebStreamsOfOne = 48;

// Floors that are drawn at a time, and bytes of free space that one is drawn of, each up to a
// hundred times as much in memory while it is: three storeys of 150 x 150 m at 0.05 m. Beyond, 503
// and 429.
inline constexpr size_t kFloorsAtOnce = 2, kFloorBytes = size_t{16} << 20;
// Metres: maps end long before it.
inline constexpr double kEndlessM = 1e7;

// Bytes of a request: an edit is some kB. More would let strangers have more parsed.
inline constexpr size_t kBodyBytes = size_t{1} << 20;

// The time that a call with one answer may take; those that wait for estimation take seconds.
inline constexpr std::chrono::seconds kCallTime{120};

// Interval of looking whether the client of a call is still there.
inline constexpr std::chrono::milliseconds kLookTime{200};

// After so long without a message a stream says that it is alive, by an empty line. Proxies close a
// stream that is silent for a minute.
inline constexpr std::chrono::milliseconds kSilence{5'000};

// Time for which the headers of a stream wait for its first message: an error that comes until then
// has a code of its own.
inline constexpr std::chrono::milliseconds kHoldHeaders{1'000};

// Seconds after which a client that was refused for a limit may come again.
inline constexpr int kRetryAfterS = 2;

// Characters of a token, of ours and of others in front of us: none is as long.
inline constexpr size_t kMaxToken = 256;

}  // namespace isthmus::web
