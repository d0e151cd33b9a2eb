#include "core/io/secret.h"

#include <absl/strings/str_cat.h>
#include <openssl/crypto.h>
#include <sys/random.h>

#include <cerrno>

#include "core/io/file_io.h"

namespace isthmus::io {

absl::StatusOr<std::string> RandomBytes(size_t size) {
  std::string bytes(size, '\0');
  for (size_t filled = 0; filled < size;) {
    const ssize_t count = getrandom(bytes.data() + filled, size - filled, 0);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      return absl::InternalError(absl::StrCat("no random bytes to be had: ", Explain(errno)));
    }
    filled += static_cast<size_t>(count);
  }
  return bytes;
}

bool SameSecret(absl::string_view a, absl::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace isthmus::io
