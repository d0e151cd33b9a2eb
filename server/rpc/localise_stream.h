// LocalisationService.Localise; see api/isthmus/v1/localisation_service.proto.
#pragma once

#include <absl/status/statusor.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <cstdint>
#include <memory>
#include <string>

#include "core/ids.h"
#include "core/records/event.h"
#include "core/records/localisation.h"
#include "isthmus/v1/localisation_service.pb.h"
#include "server/pipeline.h"
#include "server/rpc/streams/stream_reactor.h"

namespace isthmus::rpc {

using LocaliseReactorBase =
    StreamReactor<grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>>;

// The next scan is read when the place of the one before was written. Ends at once when the server
// stops: nothing of it has to be kept.
class LocaliseReactor final : public LocaliseReactorBase {
 public:
  LocaliseReactor(StreamHost* host, grpc::CallbackServerContext* context)
      : LocaliseReactorBase(host, &host->localisers, context, "Localise") {}

  void OnWriteDone(bool ok) override;

 private:
  void OnMessage(grpc::ByteBuffer message) override;
  void OnReadsDone() override { End(absl::OkStatus()); }
  void OnEnd() override;

  absl::Status Open(const v1::LocaliseRequest& request);
  absl::StatusOr<LocalisedScan> Locate(v1::LocaliseRequest* request);

  void NoteEvent(EventKind kind, const std::string& what) const;

  std::unique_ptr<server::RobotLocaliser> localiser_;
  RobotId robot_;  // Empty: it gave no name.
  uint64_t scans_ = 0, found_ = 0;
  grpc::ByteBuffer place_;
};

}  // namespace isthmus::rpc
