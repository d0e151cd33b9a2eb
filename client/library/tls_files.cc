#include "client/library/tls_files.h"

#include "core/io/file_io.h"
#include "core/tls/certificate.h"

namespace isthmus::client {
namespace {

absl::Status CheckAuthority(const std::string& path) {
  if (path.empty() || path == "system") return absl::OkStatus();
  const auto pem = io::ReadFile(path);
  return pem.ok() ? tls::CheckCertificates(path, *pem) : pem.status();
}

}  // namespace

absl::Status CheckTlsFiles(const TlsOptions& tls) {
  if (tls.certificate.empty() != tls.key.empty()) {
    return absl::InvalidArgumentError(
        "our certificate and its key (--tls-cert, --tls-key) go together: give both");
  }
  absl::Status status = CheckAuthority(tls.ca);
  if (!status.ok() || tls.certificate.empty()) return status;
  const auto certificate = io::ReadFile(tls.certificate);
  if (!certificate.ok()) return certificate.status();
  const auto key = io::ReadFile(tls.key);
  if (!key.ok()) return key.status();
  return tls::CheckKeyPair(tls.certificate, *certificate, tls.key, *key);
}

}  // namespace isthmus::client
