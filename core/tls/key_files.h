// The files that a server speaks TLS by, read anew when they change.
#pragma once

#include <absl/status/statusor.h>

#include <string>

namespace isthmus::tls {

// PEM files.
struct KeyFiles {
  // The server's certificate, with its signers' behind it; empty, as its key: plain text.
  std::string certificate = {}, key = {};
  std::string client_ca = {};  // Signer of clients' certificates; empty: none are asked for.
};

struct KeyTexts {
  std::string certificate = {}, key = {}, client_ca = {};  // PEM.
  bool operator==(const KeyTexts&) const = default;
};

// All that is named, as of one moment as far as that can be seen: it belongs together and is whole.
// Empty without files. InvalidArgument where one of certificate and key is missing; errors of
// CheckKeyPair, CheckIsSecret and CheckCertificates.
absl::StatusOr<KeyTexts> ReadKeyFiles(const KeyFiles& files);

// Changes whenever one of the files does, which are not read for it.
std::string StampOf(const KeyFiles& files);

}  // namespace isthmus::tls
