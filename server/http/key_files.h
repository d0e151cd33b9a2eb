// The files that a listener speaks TLS by, read anew when they change.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "server/http/listener.h"

namespace isthmus::http {

struct KeyTexts {
  std::string certificate = {}, key = {}, client_ca = {};  // PEM.
  bool operator==(const KeyTexts&) const = default;
};

// Empty without files. InvalidArgument where one of certificate and key is missing; errors of
// tls::CheckKeyPair and ReadCertificate.
absl::StatusOr<KeyTexts> ReadKeyFiles(const KeyFiles& files);

// Changes whenever one of the files does, which are not read for it.
std::string StampOf(const KeyFiles& files);

}  // namespace isthmus::http
