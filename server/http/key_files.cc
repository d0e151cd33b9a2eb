#include "server/http/key_files.h"

#include <absl/strings/str_cat.h>
#include <sys/stat.h>

#include "core/io/file_io.h"
#include "core/tls/certificate.h"

namespace isthmus::http {

absl::StatusOr<KeyTexts> ReadKeyFiles(const KeyFiles& files) {
  if (files.certificate.empty() && files.key.empty()) return KeyTexts();
  if (files.certificate.empty() || files.key.empty()) {
    return absl::InvalidArgumentError("a certificate and its key go together: name both");
  }
  if (absl::Status status = tls::CheckKeyPair(files.certificate, files.key); !status.ok()) {
    return status;
  }
  const auto certificate = io::ReadFile(files.certificate), key = io::ReadFile(files.key);
  if (!certificate.ok()) return certificate.status();
  if (!key.ok()) return key.status();
  KeyTexts texts = {*certificate, *key};
  if (files.client_ca.empty()) return texts;
  const auto authority = tls::ReadCertificate(files.client_ca);
  if (!authority.ok()) return authority.status();
  const auto text = io::ReadFile(files.client_ca);
  if (!text.ok()) return text.status();
  texts.client_ca = *text;
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

}  // namespace isthmus::http
