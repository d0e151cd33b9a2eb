// Robots that are looked for in the map. What the method returns and fails with is said in
// api/isthmus/v1/localisation_service.proto.
#pragma once

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include "isthmus/v1/localisation_service.grpc.pb.h"
#include "server/rpc/localise_stream.h"
#include "server/rpc/streams/stream_host.h"

namespace isthmus::rpc {

// Thread safe. The host must outlive it.
class LocalisationService final : public v1::LocalisationService::WithRawCallbackMethod_Localise<
                                      v1::LocalisationService::Service> {
 public:
  explicit LocalisationService(StreamHost* host) : host_(*host) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Localise(
      grpc::CallbackServerContext* context) override {
    return LocaliseReactorBase::Begin<LocaliseReactor>(&host_, context);
  }

 private:
  StreamHost& host_;
};

}  // namespace isthmus::rpc
