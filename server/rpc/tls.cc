#include "server/rpc/tls.h"

#include <absl/strings/str_cat.h>
#include <grpcpp/security/tls_certificate_provider.h>
#include <grpcpp/security/tls_credentials_options.h>

#include "core/address.h"
#include "core/tls/certificate.h"
#include "server/rpc/streams/limits.h"

namespace isthmus::rpc {

absl::StatusOr<std::shared_ptr<grpc::ServerCredentials>> MakeServerCredentials(
    const TlsOptions& options) {
  if (options.certificate.empty() && options.key.empty()) {
    if (options.client_ca.empty()) return grpc::InsecureServerCredentials();
    return absl::InvalidArgumentError(
        "network.tls_client_ca asks robots for certificates, which needs TLS: set "
        "network.tls_certificate and network.tls_key too");
  }
  if (options.certificate.empty() || options.key.empty()) {
    return absl::InvalidArgumentError(
        "network.tls_certificate and network.tls_key go together: set both");
  }
  if (absl::Status status = tls::CheckKeyPair(options.certificate, options.key); !status.ok()) {
    return status;
  }
  if (!options.client_ca.empty()) {
    const auto authority = tls::ReadCertificate(options.client_ca);
    if (!authority.ok()) return authority.status();
  }
  namespace experimental = grpc::experimental;
  auto provider = std::make_shared<experimental::FileWatcherCertificateProvider>(
      options.key, options.certificate, options.client_ca, kCertificateReloadS);
  experimental::TlsServerCredentialsOptions credentials(provider);
  credentials.watch_identity_key_cert_pairs();
  if (!options.client_ca.empty()) {
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
