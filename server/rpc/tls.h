// The server's side of TLS: who it says it is, and whom it asks.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <grpcpp/security/server_credentials.h>

#include <memory>

#include "server/rpc/server.h"
#include "server/rpc/watched_keys.h"

namespace isthmus::rpc {

// Null for plain text: without a certificate. InvalidArgument where one of certificate and key is
// missing; errors of WatchedKeys::Open.
absl::StatusOr<std::unique_ptr<WatchedKeys>> OpenKeys(const tls::KeyFiles& files);

// Follows the keys within seconds: new connections see the new certificate, old ones go on. They
// must outlive the server. Plain text for null.
std::shared_ptr<grpc::ServerCredentials> MakeServerCredentials(const WatchedKeys* keys);

// FailedPrecondition, saying what to do, where an address that others than this machine reach would
// be served in plain text and `insecure` does not say so.
absl::Status CheckListening(const ServerOptions& options);

}  // namespace isthmus::rpc
