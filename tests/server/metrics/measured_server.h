// A server whose work is counted, on real sockets; its store is in memory.
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "server/metrics/metrics.h"
#include "server/pipeline.h"
#include "server/rpc/server.h"
#include "storage/memory_store.h"
#include "tests/server/metrics/scrape.h"
#include "tests/server/rpc/room_scans.h"
#include "tests/server/rpc/stubs.h"

namespace isthmus::metrics {

template <typename Value>
Value OrThrow(absl::StatusOr<Value> value) {
  if (!value.ok()) throw std::runtime_error(std::string(value.status().message()));
  return *std::move(value);
}

class MeasuredServer {
 public:
  using Response = v1::StreamScansResponse;

  explicit MeasuredServer(int robots = kNamedRobots,
                          std::unique_ptr<storage::MapStore> store = storage::MakeMemoryStore())
      : metrics({.listen = "127.0.0.1:0", .robots = robots}, "1.2.3") {
    server::PipelineOptions options;
    options.composition_interval_s = 0;
    options.observer = metrics.ObserverOf("default");
    pipeline = OrThrow(server::Pipeline::Open(options, std::move(store)));
    rpc::ServerOptions listen;
    listen.listen = "127.0.0.1:0";
    listen.on_ended_call = [this](const std::string& rpc, absl::StatusCode code, double seconds) {
      metrics.NoteCall(rpc, code, seconds);
    };
    server = OrThrow(rpc::RpcServer::Start(pipeline.get(), listen));
    const absl::Status served = metrics.Serve({{"default", pipeline.get()}});
    if (!served.ok()) throw std::runtime_error(std::string(served.message()));
    stubs = std::make_unique<rpc::Stubs>(
        grpc::CreateChannel(server->address(), grpc::InsecureChannelCredentials()));
  }
  ~MeasuredServer() { metrics.Stop(); }

  // Streams them to their end; each acknowledgement of a scan.
  std::vector<Response> Stream(const std::string& session,
                               std::vector<v1::StreamScansRequest> requests) {
    const auto context = rpc::NewContext();
    auto wire = stubs->sessions->StreamScans(context.get());
    if (!requests.empty()) requests.front().set_session(session);
    for (const auto& request : requests) wire->Write(request);
    wire->WritesDone();
    std::vector<Response> acks;
    for (Response ack; wire->Read(&ack);) {
      if (ack.sequence() != 0) acks.push_back(ack);
    }
    EXPECT_GRPC_OK(wire->Finish());
    return acks;
  }
  void Finish(const std::string& session) {
    v1::FinishSessionRequest finish;
    finish.set_session(session);
    v1::Session finished;
    EXPECT_GRPC_OK(stubs->sessions->FinishSession(rpc::NewContext().get(), finish, &finished));
  }
  // Drives a robot through the room and finishes its session.
  void Drive(const std::string& robot, uint64_t scans) {
    const std::string session = stubs->NewSession(robot);
    std::vector<v1::StreamScansRequest> requests;
    for (uint64_t i = 1; i <= scans; ++i) requests.push_back(rpc::RoomScan("", i));
    EXPECT_EQ(Stream(session, requests).size(), scans);
    Finish(session);
  }
  Scrape Ask() const { return Scrape::Of(metrics.address()); }

  Metrics metrics;
  std::unique_ptr<server::Pipeline> pipeline;
  std::unique_ptr<rpc::RpcServer> server;
  std::unique_ptr<rpc::Stubs> stubs;
};

}  // namespace isthmus::metrics
