// Limits of calls: what one caller and all of them may hold, and for how long.
//
// What a person may set is in StreamOptions and CallLimitOptions, with these as defaults. Guesses
// that were never varied, but for what names a reason.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace isthmus::rpc {

// Threads for what streams ask for: taking scans in waits for the disk at most, so that two are
// there when one waits; decoding uploads and looking for robots takes seconds of a core.
inline constexpr int kScanThreads = 2, kUploadThreads = 2, kLocaliseThreads = 2;
// And for those who watch the event log or the map: reading a page of it, or finding what changed,
// takes a millisecond.
inline constexpr int kWatchThreads = 1;
// Events of one response to who watches: what a slow reader holds, some hundred kB.
inline constexpr size_t kEventsPerResponse = 256;

// Interval at which watchers of a map are told where robots are, as the API says.
inline constexpr std::chrono::milliseconds kRobotsInterval{500};
// Levels of detail that may be asked for: an int32 has no more bits.
inline constexpr uint32_t kMaxTileLevel = 30;

// Time for a stream to say what it is about. A client that opened it for something says so at once.
inline constexpr std::chrono::milliseconds kFirstMessage{10'000};
// Time that an upload may stand still, and that a reader may leave what was sent to it unread. A
// radio link that is gone for longer is noticed as dead by its pings within 50 s.
inline constexpr std::chrono::milliseconds kProgress{60'000};
// Interval at which a stream whose scan found no room looks again if no acknowledgement wakes it:
// fractions of a scan's interval.
inline constexpr std::chrono::milliseconds kLookAgain{50};
// Interval between looks at timers; the waits that they guard take seconds.
inline constexpr std::chrono::milliseconds kTick{25};

// Streams of one caller: a fleet behind one address has some tens.
inline constexpr size_t kStreamsPerCaller = 256;
// All streams: each takes some tens of kB while it is idle.
inline constexpr size_t kStreams = 2000;
// Scans that all streams hold together: memory.
inline constexpr size_t kAllStreamBytes = size_t{256} << 20;
// Streams that may hold all that they can at a time: by default each has 32 MiB, two of the largest
// scans that are taken, without an acknowledgement before no more is read of it.
inline constexpr size_t kStreamsAtTheirMost = 8;
// Bytes on their way through all connections beside the scans that streams hold. Beyond both
// connections are closed. Less, and a few large scans of a server with small streams close theirs.
inline constexpr size_t kConnectionSpareBytes = size_t{256} << 20;
// Wait that a caller is told when it was refused for a limit: about the time of a query.
inline constexpr std::chrono::milliseconds kRetryAfter{1'000};
// Calls of a kind that run at a time. Each may hold a thread and what it reads of the map.
// An export reads all of a map where a query reads a region.
inline constexpr size_t kQueries = 16, kQueriesPerExport = 4;
// Calls that one connection may have under way; further ones wait at the client.
inline constexpr int kCallsPerConnection = 256;

// Seconds between looks at the files of certificates: a robot that comes in the second after a
// renewal may see the old one, which is valid still.
inline constexpr unsigned kCertificateReloadS = 1;

// Characters of the reason why a scan is rejected: it may quote what came.
inline constexpr size_t kMaxReason = 300;

}  // namespace isthmus::rpc
