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
#include <vector>

#include "core/site_name.h"
#include "core/tls/key_files.h"
#include "server/access/require_token.h"
#include "server/access/tokens.h"
#include "server/pipeline.h"
#include "server/rpc/backup_source.h"
#include "server/rpc/ended_call.h"
#include "server/rpc/streams/call_limits.h"
#include "server/rpc/streams/stream_host.h"

namespace grpc {
class Channel;
}

namespace isthmus::rpc {

class Gate;

struct ServerOptions {
  // The address to listen on: "host:port", "[::1]:port" or "unix:path". Port 0 takes a free one.
  std::string listen = "127.0.0.1:50051";
  tls::KeyFiles tls = {};
  // True if an address that other machines reach may be served in plain text.
  bool insecure = false;
  // Largest message taken, bytes: the limit of one scan. A larger one ends its stream with
  // RESOURCE_EXHAUSTED.
  // 16 MiB: a turn of 128 rings and 2048 columns with all fields of an Ouster, 48 bytes a point,
  // takes 12.6 MB.
  int max_receive_bytes = 16 << 20;
  // Largest submap upload, bytes as they travel.
  uint64_t max_submap_bytes = 256u << 20;
  // The default site's, if Start is given a pipeline only; see ServedSite.
  std::string uploads_folder = {};
  // The limit on one session's uploads together, bytes.
  uint64_t max_staged_bytes = uint64_t{1} << 30;
  // Scans of one stream whose acknowledgements are not written yet; when so many are out, no more
  // are read. More than the pipeline's queue, or that never fills.
  size_t scan_window = 64;
  // Their bytes are bounded by streams.all_bytes, as is what is on its way through connections.
  StreamOptions streams = {};
  CallLimitOptions calls = {};
  // Connections of clients that may be open, see Listener::Limits. Further ones are closed at once;
  // at a socket that is a file gRPC listens, which has no such limit.
  int max_connections = 10'000;
  // Threads that serve calls with one request: each holds one while it is answered. Streams from
  // clients hold none. Calls beyond get RESOURCE_EXHAUSTED.
  int max_threads = 512;
  BackupSource backup;  // The default site's, as uploads_folder.
  // Tokens that let callers in; null: all are let in, to do anything. Must outlive the server.
  access::Tokens* tokens = nullptr;
  access::RequireToken require_token = access::RequireToken::kAuto;
  // Time within which calls under way end after their token was revoked or has expired.
  std::chrono::milliseconds token_review_interval{1000};
  // Time within which health checking tells of a service that is in trouble, or well again.
  std::chrono::milliseconds health_interval{1000};
  // Told of every call that ends with an error, from the thread that served it; may be null.
  OnFailedCall on_failed_call;
  // Told of every call that ends, let in or not, and how long it took; likewise.
  OnEndedCall on_ended_call;
};

// One of the maps that a server serves.
struct ServedSite {
  std::string name = kDefaultSite;
  server::Pipeline* pipeline = nullptr;
  // The source of backups; null: there are none (UNIMPLEMENTED). Called by one thread at a time.
  BackupSource backup = nullptr;
  // The folder for uploads under way, so that they go on after a restart; empty: in memory.
  std::string uploads_folder = {};
};

// Thread safe.
class RpcServer {
 public:
  // Listens and serves until Shutdown. The pipelines must outlive the server; a call that names no
  // site is of the first one. Unavailable, saying why, when it cannot listen at the address; an
  // address that is in use is one such reason. InvalidArgument where the address is none; errors of
  // MakeServerCredentials and CheckListening.
  static absl::StatusOr<std::unique_ptr<RpcServer>> Start(const std::vector<ServedSite>& sites,
                                                          const ServerOptions& options);
  // Serves the default site alone.
  static absl::StatusOr<std::unique_ptr<RpcServer>> Start(server::Pipeline* pipeline,
                                                          const ServerOptions& options);
  ~RpcServer();  // Shutdown without grace, if that has not happened.

  // The port it listens on, also when 0 was asked for; 0 for "unix:".
  int port() const;
  // `ServerOptions::listen` with the port filled in.
  std::string address() const;
  // To this server within the process. Once Shutdown has begun no call may: gRPC 1.51 crashes.
  std::shared_ptr<grpc::Channel> InProcessChannel();
  // For readers that are answered within the process: all calls pass it, and end before Shutdown.
  Gate& gate();

  // Has GetStatus say that browsers are served there: "https://host:port".
  void TellWebAddress(const std::string& address);

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
