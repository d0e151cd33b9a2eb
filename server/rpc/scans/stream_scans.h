// SessionService.StreamScans; see api/isthmus/v1/session_service.proto.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <memory>
#include <optional>

#include "core/scan_upload.h"
#include "isthmus/v1/session_service.pb.h"
#include "server/rpc/scans/scan_streams.h"
#include "server/rpc/streams/stream_reactor.h"

namespace isthmus::rpc {

using ScanReactorBase = StreamReactor<grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>>;

// The stream ends when the robot has half-closed and has all its acknowledgements, or something
// ended it early; the scans taken so far are acknowledged also then.
//
// A message is read only when the one before it was given to the pipeline and the window has room,
// so a robot that sends faster is slowed down by its own connection.
class ScanReactor final : public ScanReactorBase {
 public:
  ScanReactor(StreamHost* host, grpc::CallbackServerContext* context);

  void OnWriteDone(bool ok) override;

 private:
  void OnMessage(grpc::ByteBuffer message) override;
  void OnReadsDone() override;
  void OnStop() override;
  void OnEnd() override;

  // Does whatever can be done now; called whenever something has changed.
  void Pump();
  absl::Status TakeMessage();
  absl::Status BeginSession(const std::string& name);
  absl::Status TakeScan(v1::ScanMessage&& message);
  absl::Status SubmitScan();
  void WriteAck();
  // No more scans are taken; the stream ends with this once what was taken is acknowledged.
  void EndScans(const absl::Status& status);

  std::unique_ptr<ScanStreams::Registration> registration_;  // From the first message on.
  std::optional<grpc::ByteBuffer> message_;                  // Waits for its share of memory.
  int64_t arrived_ns_ = 0;                                   // Arrival of the newest message.
  std::unique_ptr<ByteBudget::Share> share_;                 // The message's, then the scan's.
  std::optional<ScanUpload> scan_;  // Waits for room in the session's queue.
  std::string reason_;              // Why that scan is rejected, where that is known.
  grpc::ByteBuffer ack_;
  bool writing_ = false;
  std::optional<absl::Status> status_;  // The stream ends with this.
  Watchdog::Timer look_again_;
};

}  // namespace isthmus::rpc
