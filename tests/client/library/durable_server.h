// DurableSessions over a real socket, by gRPC.
#pragma once

#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <chrono>
#include <memory>
#include <string>

#include "client/library/client.h"
#include "isthmus/v1/session_service.grpc.pb.h"
#include "tests/client/library/durable_sessions.h"

namespace isthmus::client {

class DurableServer final : public DurableSessions, private v1::SessionService::Service {
 public:
  DurableServer() { Start(); }
  ~DurableServer() override { Stop(); }

  // From the next Start on; 0: gRPC's 4 MiB.
  int max_message_bytes = 0;

  void Start() {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:" + std::to_string(port_),
                             grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(this);
    if (max_message_bytes > 0) builder.SetMaxReceiveMessageSize(max_message_bytes);
    server_ = builder.BuildAndStart();
  }
  void Stop() {
    if (server_ != nullptr) server_->Shutdown(std::chrono::system_clock::now());
    server_.reset();
  }
  // As after kill -9.
  void Crash() {
    Stop();
    Forget();
  }

  std::unique_ptr<Client> Connect(ClientOptions options) {
    options.address = "127.0.0.1:" + std::to_string(port_);
    auto client = Client::Connect(options);
    return client.ok() ? *std::move(client) : nullptr;
  }

 private:
  using Stream = grpc::ServerReaderWriter<v1::StreamScansResponse, v1::StreamScansRequest>;

  static grpc::Status ToGrpc(const absl::Status& status) {
    return {static_cast<grpc::StatusCode>(status.code()), std::string(status.message())};
  }

  grpc::Status CreateSession(grpc::ServerContext*, const v1::CreateSessionRequest* request,
                             v1::Session* session) override {
    return ToGrpc(Create(*request, session));
  }
  grpc::Status GetSession(grpc::ServerContext*, const v1::GetSessionRequest* request,
                          v1::Session* session) override {
    return ToGrpc(Get(*request, session));
  }
  grpc::Status FinishSession(grpc::ServerContext*, const v1::FinishSessionRequest* request,
                             v1::Session* session) override {
    return ToGrpc(Finish(*request, session));
  }

  grpc::Status StreamScans(grpc::ServerContext* context, Stream* stream) override {
    if (BeginStream()) return BeMute(*context, *stream);
    v1::StreamScansRequest request;
    std::string session;
    for (int scans = 0; stream->Read(&request);) {
      if (!request.session().empty()) session = request.session();
      if (!request.has_scan()) continue;
      v1::StreamScansResponse ack;
      const absl::Status status = Take(session, request.scan(), ack);
      if (!status.ok()) return ToGrpc(status);
      if (++scans == break_every) return ToGrpc(Broken());
      stream->Write(ack);
    }
    return grpc::Status::OK;
  }

  grpc::Status BeMute(grpc::ServerContext& context, Stream& stream) {
    v1::StreamScansRequest request;
    while (stream.Read(&request)) {
      if (request.has_scan()) Mute();
    }
    return {grpc::StatusCode::UNAVAILABLE, context.IsCancelled() ? "hung up" : "ended"};
  }

  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
};

using TestServer = DurableServer;

}  // namespace isthmus::client
