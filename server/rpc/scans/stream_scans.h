// SessionService.StreamScans; see api/isthmus/v1/session_service.proto.
#pragma once

#include <absl/status/status.h>

#include <functional>

#include "isthmus/v1/session_service.pb.h"
#include "server/rpc/call.h"

namespace isthmus::rpc {

// The link to one robot. Read and write may be used by two threads at a time.
struct ScanLink {
  std::function<bool(v1::StreamScansRequest*)> read;  // False after the last, or when broken.
  std::function<bool(const v1::StreamScansResponse&)> write;  // False when broken.
  std::function<void()> cancel;  // Makes read and write return false. Never blocks.
};

// Returns when the robot has half-closed and has all its acknowledgements, or something ended the
// stream early; the scans taken so far are acknowledged also then.
absl::Status StreamScans(const Call& call, const ScanLink& link);

}  // namespace isthmus::rpc
