// One uploaded submap, put together from its chunks.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "isthmus/v1/session_service.pb.h"
#include "server/rpc/upload_staging.h"

namespace isthmus::rpc {

// Puts the chunks of one upload together, behind what arrived of it before. Not thread safe.
class SubmapReceiver {
 public:
  // At most `max_bytes` are taken, whatever the header says. `taken_over` is called, from any
  // thread, when a newer call sends the same submap; it must not wait, nor call back.
  SubmapReceiver(uint64_t max_bytes, UploadStaging& staging,
                 std::function<void()> taken_over = nullptr)
      : max_bytes_(max_bytes), staging_(staging), taken_over_(std::move(taken_over)) {}

  // InvalidArgument when the first part is not a header or a later one is; OutOfRange for a chunk
  // that leaves a gap or runs past the size announced; ResourceExhausted beyond the limit.
  absl::Status Add(v1::UploadSubmapRequest&& part);
  // DataLoss when bytes are missing, which may follow in another call, or when they are not what
  // the header says: then nothing stays of them. To be called once, after the last Add.
  absl::StatusOr<v1::UploadSubmapHeader> Finish();  // header.cloud.data holds the bytes.

  bool has_header() const { return has_header_; }
  const v1::UploadSubmapHeader& header() const { return header_; }

 private:
  absl::Status AddChunk(const v1::UploadSubmapChunk& chunk);

  const uint64_t max_bytes_;
  UploadStaging& staging_;
  const std::function<void()> taken_over_;
  bool has_header_ = false;
  v1::UploadSubmapHeader header_;
  std::unique_ptr<UploadStaging::Part> part_;
};

}  // namespace isthmus::rpc
