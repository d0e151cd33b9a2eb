// Judged limits of the service over HTTP.
#pragma once

#include <chrono>
#include <cstddef>

namespace isthmus::http {

// Time a client may take for a request, from its connection or the answer before it to the last
// byte; a connection without a request is closed then. People's browsers open connections ahead and
// use them within seconds; 1 MiB in that time is 0.5 Mbit/s. Longer, and clients that send half a
// request hold their connections longer.
inline constexpr std::chrono::seconds kRequestTime{15};

// Time a client may take to read on by one piece of an answer: by then the bytes sent before have
// left. 32 KiB in that time are 9 kbit/s, less than any link that a person would wait at.
inline constexpr std::chrono::seconds kPieceTime{30};

// Bytes of an answer handed over at a time.
inline constexpr size_t kPieceBytes = 32 << 10;

// Memory of a connection, bytes: the headers of a request, and a piece of its answer. Half of the
// common size would do for cookies and tokens; less than two pieces makes answers slow.
inline constexpr size_t kConnectionBytes = 64 << 10;

// Time for which a listener that ends waits for its connections, which it has cut: the work for
// them notices within that time. kCutInterval lies between two rounds of cutting, for connections
// that come meanwhile.
inline constexpr std::chrono::seconds kEndTime{5};
inline constexpr std::chrono::milliseconds kCutInterval{20};

// Interval of looking for connections that have used up their time, and for a changed certificate.
inline constexpr std::chrono::milliseconds kLookInterval{500};

}  // namespace isthmus::http
