// The interface behind a scan stream. Private to the library.
#pragma once

#include "client/library/stream/scan_stream.h"

namespace isthmus::client {

class ScanStream::Impl {
 public:
  virtual ~Impl() = default;
  virtual absl::Status Push(int64_t end_stamp_ns, PointPayload payload) = 0;
  virtual absl::Status Finish() = 0;
  virtual absl::StatusOr<SessionStatus> FinishSession() = 0;
  virtual void GiveUp() = 0;
  virtual ScanStreamStats stats() const = 0;
  virtual SpoolState resumed() const = 0;
  virtual std::optional<bool> IsNewest(int64_t end_stamp_ns, PointPayload payload) const = 0;
  virtual SessionId session() const = 0;
};

}  // namespace isthmus::client
