// Judged limits of what is served over HTTP.
#pragma once

#include <chrono>
#include <cstddef>

namespace isthmus::http {

// How long a client may take for a request, from its connection or the answer before it to the last
// byte; a connection without one is closed then. People's browsers open connections ahead and use
// them within seconds; 1 MiB in that time is 0.5 Mbit/s. Longer, and clients that say half a word
// hold their connections longer.
inline constexpr std::chrono::seconds kRequestTime{15};

// How long it may take to read one piece of an answer on: then what was sent before has left.
// 32 KiB in that time are 9 kbit/s, less than any link that a person would wait at.
inline constexpr std::chrono::seconds kPieceTime{30};

// Bytes of an answer handed over at a time.
inline constexpr size_t kPieceBytes = 32 << 10;

// Memory of a connection, bytes: the headers of a request, and a piece of its answer. Half of what
// servers commonly take would do for cookies and tokens; less than two pieces makes answers slow.
inline constexpr size_t kConnectionBytes = 64 << 10;

// How long a listener that ends waits for its connections, which it has cut: what is computed for
// them takes no longer to notice. Between two rounds of cutting, for those that come meanwhile.
inline constexpr std::chrono::seconds kEndTime{5};
inline constexpr std::chrono::milliseconds kCutInterval{20};

// How often it is looked whether a connection has used up its time, or the certificate has changed.
inline constexpr std::chrono::milliseconds kLookInterval{500};

}  // namespace isthmus::http
