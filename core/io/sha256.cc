#include "core/io/sha256.h"

#include <openssl/evp.h>

#include <array>

namespace isthmus::io {

std::string Sha256(const void* data, size_t size) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest = {};
  unsigned int length = 0;
  if (EVP_Digest(data, size, digest.data(), &length, EVP_sha256(), nullptr) != 1) return {};
  return std::string(reinterpret_cast<const char*>(digest.data()), length);
}

}  // namespace isthmus::io
