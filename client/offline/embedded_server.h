// A server of the command's own, for the commands that need no other: the same pipeline and the
// same way in as isthmus-server, with a store that ends with the process.
#pragma once

#include <absl/status/statusor.h>

#include <memory>

#include "client/library/client.h"
#include "core/records/map_graph.h"
#include "server/pipeline_options.h"

namespace isthmus::server {
class Pipeline;
}
namespace isthmus::rpc {
class RpcServer;
}

namespace isthmus::cli {

// Listens on a free port of 127.0.0.1 until destroyed.
class EmbeddedServer {
 public:
  static absl::StatusOr<std::unique_ptr<EmbeddedServer>> Start(
      const server::PipelineOptions& options);
  ~EmbeddedServer();

  client::Client& client() { return *client_; }
  // As Client::GetMatchGraph, with the rivals of each match.
  MatchGraph GetMatchGraph() const;

 private:
  EmbeddedServer() = default;

  // In the order in which they depend on each other.
  std::unique_ptr<server::Pipeline> pipeline_;
  std::unique_ptr<rpc::RpcServer> rpc_;
  std::unique_ptr<client::Client> client_;
};

}  // namespace isthmus::cli
