// X.509 certificates in PEM files, as servers and robots present them.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/time/time.h>

#include <string>
#include <vector>

namespace isthmus::tls {

struct Certificate {
  std::string subject;             // Its common name.
  std::string issuer;              // Its issuer's common name.
  std::vector<std::string> names;  // Hosts and addresses that it is for.
  absl::Time not_before, not_after;
  bool is_authority = false;  // It may sign others.
};

// The first one in a PEM text. InvalidArgument where there is none.
absl::StatusOr<Certificate> ParseCertificate(const std::string& pem);

// The first one of a file. Errors name the file and say what to do.
absl::StatusOr<Certificate> ReadCertificate(const std::string& path);

// Checks that a PEM text is of certificates, one at least, and that none is cut off.
// FailedPrecondition, naming the file that it is from.
absl::Status CheckCertificates(const std::string& path, const std::string& pem);

// Checks that the texts read of these files can be presented: all is whole, and the key is the
// certificate's. FailedPrecondition, saying what to do.
absl::Status CheckKeyPair(const std::string& certificate_path, const std::string& certificate,
                          const std::string& key_path, const std::string& key);

// Checks that nobody but its owner (and group) can read the file of a server's key.
// FailedPrecondition, saying what to do.
absl::Status CheckIsSecret(const std::string& key_path);

}  // namespace isthmus::tls
