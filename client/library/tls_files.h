// The files that a client speaks TLS by, looked at before there is a connection. Private to the
// library and the command line.
#pragma once

#include <absl/status/status.h>

#include "client/library/options.h"

namespace isthmus::client {

// Checks that they are what TlsOptions names them for: gRPC would only say that no connection came
// about, and log why again and again. InvalidArgument where one of certificate and key is missing;
// else errors of io::ReadFile, tls::CheckCertificates and tls::CheckKeyPair, which name the file.
absl::Status CheckTlsFiles(const TlsOptions& tls);

}  // namespace isthmus::client
