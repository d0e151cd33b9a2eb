#include "core/formats/lzf.h"

#include <absl/strings/str_cat.h>
#include <lzf.h>

#include <cstdint>
#include <limits>

#include "core/codec/column.h"

namespace isthmus::formats {
namespace {

constexpr size_t kLzfHeaderSize = 8;
// A back reference of 3 bytes gives at most 264.
constexpr size_t kMaxRatio = 88;

}  // namespace

absl::StatusOr<std::string> LzfBlock(const std::string& content) {
  // Incompressible input grows by one byte in 32.
  const size_t bound = content.size() + content.size() / 16 + 64;
  if (bound > std::numeric_limits<uint32_t>::max()) {
    return absl::ResourceExhaustedError(
        "binary_compressed PCD cannot hold more than 4 GiB; use binary");
  }
  std::string block(kLzfHeaderSize + bound, '\0');
  unsigned int packed = 0;
  if (!content.empty()) {
    packed = lzf_compress(content.data(), static_cast<unsigned int>(content.size()),
                          block.data() + kLzfHeaderSize, static_cast<unsigned int>(bound));
    if (packed == 0) return absl::InternalError("LZF needed more room than its bound");
  }
  codec::StoreAs(static_cast<uint32_t>(packed), block.data());
  codec::StoreAs(static_cast<uint32_t>(content.size()), block.data() + 4);
  block.resize(kLzfHeaderSize + packed);
  return block;
}

absl::StatusOr<std::string> ReadLzfBlock(const char* block, size_t size, size_t content_size) {
  if (size < kLzfHeaderSize) return absl::InvalidArgumentError("the compressed data is truncated");
  const uint32_t packed = codec::LoadAs<uint32_t>(block);
  const uint32_t unpacked = codec::LoadAs<uint32_t>(block + 4);
  if (packed > size - kLzfHeaderSize) {
    return absl::InvalidArgumentError(absl::StrCat("the compressed data is truncated: ", packed,
                                                   " bytes announced, ", size - kLzfHeaderSize,
                                                   " there"));
  }
  if (unpacked != content_size || content_size > packed * kMaxRatio) {
    return absl::InvalidArgumentError(absl::StrCat("the header announces points of ", content_size,
                                                   " bytes, the compressed data ", unpacked, " in ",
                                                   packed));
  }
  std::string content(content_size, '\0');
  if (content_size > 0 &&
      lzf_decompress(block + kLzfHeaderSize, packed, content.data(), unpacked) != unpacked) {
    return absl::InvalidArgumentError("the compressed data is damaged");
  }
  return content;
}

}  // namespace isthmus::formats
