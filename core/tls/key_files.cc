#include "core/tls/key_files.h"

#include <absl/strings/str_cat.h>
#include <sys/stat.h>

#include "core/io/file_io.h"
#include "core/tls/certificate.h"

namespace isthmus::tls {

absl::StatusOr<KeyTexts> ReadKeyFiles(const KeyFiles& files) {
  if (files.certificate.empty() && files.key.empty()) return KeyTexts();
  if (files.certificate.empty() || files.key.empty()) {
    return absl::InvalidArgumentError("a certificate and its key go together: name both");
  }
  const auto certificate = io::ReadFile(files.certificate);
  if (!certificate.ok()) return certificate.status();
  const auto key = io::ReadFile(files.key);
  if (!key.ok()) return key.status();
  KeyTexts texts = {*certificate, *key};
  absl::Status status = CheckKeyPair(files.certificate, texts.certificate, files.key, texts.key);
  if (status.ok()) status = CheckIsSecret(files.key);
  if (!status.ok()) return status;
  if (files.client_ca.empty()) return texts;
  const auto authority = io::ReadFile(files.client_ca);
  if (!authority.ok()) return authority.status();
  texts.client_ca = *authority;
  status = CheckCertificates(files.client_ca, texts.client_ca);
  if (!status.ok()) return status;
  return texts;
}

std::string StampOf(const KeyFiles& files) {
  std::string stamp;
  for (const std::string& path : {files.certificate, files.key, files.client_ca}) {
    struct stat state = {};
    if (path.empty() || stat(path.c_str(), &state) != 0) state = {};
    absl::StrAppend(&stamp, state.st_ino, " ", state.st_size, " ", state.st_mtim.tv_sec, ".",
                    state.st_mtim.tv_nsec, "\n");
  }
  return stamp;
}

}  // namespace isthmus::tls
