// The network skin of the server: gRPC services over a pipeline, health checking and reflection.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "server/pipeline.h"
#include "server/rpc/backup_source.h"
#include "server/rpc/streams/call_limits.h"
#include "server/rpc/streams/stream_host.h"

namespace grpc {
class Channel;
}

namespace isthmus::rpc {

struct ServerOptions {
  // The address to listen on: "host:port", "[::1]:port" or "unix:path". Port 0 takes a free one.
  // There is no authentication: whoever reaches the address may read and write the map.
  std::string listen = "127.0.0.1:50051";
  // Largest message taken, bytes: the limit of one scan. A larger one ends its stream with
  // RESOURCE_EXHAUSTED.
  // 16 MiB: a turn of 128 rings and 2048 columns with all fields of an Ouster, 48 bytes a point,
  // takes 12.6 MB.
  int max_receive_bytes = 16 << 20;
  // Largest submap upload, bytes as they travel.
  uint64_t max_submap_bytes = 256u << 20;
  // The folder for uploads under way, so that they go on after a restart; empty: in memory.
  std::string uploads_folder = {};
  // The limit on one session's uploads together, bytes.
  uint64_t max_staged_bytes = uint64_t{1} << 30;
  // Scans of one stream whose acknowledgements are not written yet; when so many are out, no more
  // are read. More than the pipeline's queue, or that never fills.
  size_t scan_window = 64;
  // Scans of one stream likewise, bytes; one may always be under way.
  size_t stream_bytes = kStreamBytes;
  StreamOptions streams = {};
  CallLimitOptions calls = {};
  // Calls that one connection may have under way; further ones wait at the client.
  int max_calls_per_connection = 256;
  // Memory for what is on its way through all connections, bytes. Beyond it connections are closed.
  size_t connection_bytes = size_t{512} << 20;
  // Threads that serve calls with one request: each holds one while it is answered. Streams from
  // clients hold none. Calls beyond get RESOURCE_EXHAUSTED.
  int max_threads = 512;
  // The source of backups; null: there are none (UNIMPLEMENTED). Called by one thread at a time.
  BackupSource backup;
  // Told of every call that ends with an error, from the thread that served it; may be null.
  std::function<void(const std::string& rpc, const absl::Status& status)> on_failed_call;
};

// Thread safe.
class RpcServer {
 public:
  // Listens and serves until Shutdown. The pipeline must outlive the server. Unavailable, saying
  // why, when it cannot listen at the address; an address that is in use is one such reason.
  // InvalidArgument where the address is none.
  static absl::StatusOr<std::unique_ptr<RpcServer>> Start(server::Pipeline* pipeline,
                                                          const ServerOptions& options);
  ~RpcServer();  // Shutdown without grace, if that has not happened.

  // The port it listens on, also when 0 was asked for; 0 for "unix:".
  int port() const;
  // `ServerOptions::listen` with the port filled in.
  std::string address() const;
  // To this server within the process, without a socket; for commands that bring their own server.
  std::shared_ptr<grpc::Channel> InProcessChannel();

  // Takes no further calls, ends scan streams once the scans read from them are acknowledged, waits
  // for calls under way, and cancels those that still run after `grace`. Health turns NOT_SERVING
  // at once. The pipeline must still be running: it owes the acknowledgements. Idempotent.
  void Shutdown(std::chrono::milliseconds grace);

 private:
  struct State;
  explicit RpcServer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isthmus::rpc
