// The callback by which a handler streams its responses without knowing the transport.
#pragma once

#include <absl/status/status.h>

#include <functional>

namespace isthmus::rpc {

// Waits until the transport has taken the response; returns false once the reader has gone away.
template <typename Response>
using Emit = std::function<bool(const Response&)>;

inline absl::Status ReaderGone() { return absl::CancelledError("the client stopped reading"); }

}  // namespace isthmus::rpc
