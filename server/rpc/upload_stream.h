// SessionService.UploadSubmap; see api/isthmus/v1/session_service.proto.
#pragma once

#include <absl/status/statusor.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <cstdint>
#include <optional>

#include "core/ids.h"
#include "core/map/submap.h"
#include "server/rpc/streams/stream_reactor.h"
#include "server/rpc/upload_submap.h"

namespace isthmus::rpc {

using UploadReactorBase = StreamReactor<grpc::ServerReadReactor<grpc::ByteBuffer>>;

// One part is dealt with before the next is read; the submap is decoded when all have come.
class UploadReactor final : public UploadReactorBase {
 public:
  // At most `max_submap_bytes` are taken, as they travel.
  UploadReactor(StreamHost* host, grpc::CallbackServerContext* context, grpc::ByteBuffer* response,
                uint64_t max_submap_bytes);

 private:
  void OnMessage(grpc::ByteBuffer message) override;
  void OnReadsDone() override;
  void OnEnd() override { receiver_.reset(); }

  absl::Status TakePart(grpc::ByteBuffer* message);
  absl::StatusOr<SubmapInfo> TakeSubmap();

  grpc::ByteBuffer& response_;
  const uint64_t max_submap_bytes_;
  std::optional<SubmapReceiver> receiver_;  // From the first part on.
  RobotId robot_;
};

}  // namespace isthmus::rpc
