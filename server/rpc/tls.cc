#include "server/rpc/tls.h"

#include <absl/strings/str_cat.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>

#include "core/address.h"
#include "server/rpc/streams/limits.h"

namespace isthmus::rpc {

absl::StatusOr<std::unique_ptr<WatchedKeys>> OpenKeys(const tls::KeyFiles& files) {
  if (files.certificate.empty() && files.key.empty()) {
    if (files.client_ca.empty()) return nullptr;
    return absl::InvalidArgumentError(
        "network.tls_client_ca asks robots for certificates, which needs TLS: set "
        "network.tls_certificate and network.tls_key too");
  }
  if (files.certificate.empty() || files.key.empty()) {
    return absl::InvalidArgumentError(
        "network.tls_certificate and network.tls_key go together: set both");
  }
  return WatchedKeys::Open(files);
}

std::shared_ptr<grpc::ServerCredentials> MakeServerCredentials(const WatchedKeys* keys) {
  if (keys == nullptr) return grpc::InsecureServerCredentials();
  namespace experimental = grpc::experimental;
  auto provider = std::make_shared<experimental::FileWatcherCertificateProvider>(
      keys->pair_path(), keys->pair_path(), keys->client_ca_path(), kCertificateReloadS);
  experimental::TlsServerCredentialsOptions credentials(provider);
  credentials.watch_identity_key_cert_pairs();
  if (!keys->client_ca_path().empty()) {
    credentials.watch_root_certs();
    credentials.set_cert_request_type(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  }
  return experimental::TlsServerCredentials(credentials);
}

absl::Status CheckListening(const ServerOptions& options) {
  if (options.insecure || !options.tls.certificate.empty() || IsThisMachine(options.listen)) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(absl::StrCat(
      "at ", options.listen,
      " whoever reaches this machine could read along and change the map: "
      "serve with TLS (network.tls_certificate and tls_key; `isthmus certs init` makes them), "
      "listen at 127.0.0.1, or say --insecure where the network itself is safe"));
}

}  // namespace isthmus::rpc
