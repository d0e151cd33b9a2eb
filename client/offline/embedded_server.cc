#include "client/offline/embedded_server.h"

#include <chrono>
#include <utility>

#include "server/pipeline.h"
#include "server/rpc/server.h"
#include "storage/memory_store.h"

namespace isthmus::cli {

absl::StatusOr<std::unique_ptr<EmbeddedServer>> EmbeddedServer::Start(
    const server::PipelineOptions& options) {
  std::unique_ptr<EmbeddedServer> out(new EmbeddedServer);
  auto pipeline = server::Pipeline::Open(options, storage::MakeMemoryStore());
  if (!pipeline.ok()) return pipeline.status();
  out->pipeline_ = *std::move(pipeline);
  rpc::ServerOptions rpc_options;
  rpc_options.listen = "127.0.0.1:0";
  // The user's own files and memory.
  rpc_options.max_submap_bytes = uint64_t{4} << 30;
  rpc_options.max_receive_bytes = 256 << 20;
  rpc_options.streams.all_bytes = size_t{1} << 30;
  auto rpc = rpc::RpcServer::Start(out->pipeline_.get(), rpc_options);
  if (!rpc.ok()) return rpc.status();
  out->rpc_ = *std::move(rpc);
  client::ClientOptions client_options;
  client_options.address = out->rpc_->address();
  auto client = client::Client::Connect(client_options);
  if (!client.ok()) return client.status();
  out->client_ = *std::move(client);
  return out;
}

MatchGraph EmbeddedServer::GetMatchGraph() const { return pipeline_->reader().GetMatchGraph(); }

EmbeddedServer::~EmbeddedServer() {
  client_.reset();
  if (rpc_ != nullptr) rpc_->Shutdown(std::chrono::seconds(1));
}

}  // namespace isthmus::cli
