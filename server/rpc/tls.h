// The server's side of TLS: who it says it is, and whom it asks.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <grpcpp/security/server_credentials.h>

#include <memory>
#include <string>

#include "server/rpc/server.h"

namespace isthmus::rpc {

// Files are read again as they change, within seconds: new connections see the new certificate, old
// ones go on. Plain text without a certificate. InvalidArgument where one of certificate and key is
// missing; errors of tls::CheckKeyPair.
absl::StatusOr<std::shared_ptr<grpc::ServerCredentials>> MakeServerCredentials(
    const TlsOptions& options);

// FailedPrecondition, saying what to do, where an address that others than this machine reach would
// be served in plain text and `insecure` does not say so.
absl::Status CheckListening(const ServerOptions& options);

}  // namespace isthmus::rpc
