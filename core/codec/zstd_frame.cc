#include "core/codec/zstd_frame.h"

#include <absl/strings/str_cat.h>
#include <zstd.h>

#include <memory>

#include "core/byte_stream.h"

namespace isthmus::codec {

absl::Status AppendZstdFrame(const std::string& content, std::string& out, int level) {
  // One context per thread: making one costs as much as a small frame.
  thread_local const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                                  &ZSTD_freeCCtx);
  if (context == nullptr) return absl::ResourceExhaustedError("no memory to compress");
  const size_t start = out.size();
  out.resize(start + ZSTD_compressBound(content.size()));
  const size_t size = ZSTD_compressCCtx(context.get(), out.data() + start, out.size() - start,
                                        content.data(), content.size(), level);
  if (ZSTD_isError(size)) {
    out.resize(start);
    return absl::ResourceExhaustedError(absl::StrCat("zstd: ", ZSTD_getErrorName(size)));
  }
  out.resize(start + size);
  return absl::OkStatus();
}

absl::StatusOr<std::string> ReadZstdFrame(const char* frame, size_t frame_size,
                                          size_t content_size) {
  const size_t used = ZSTD_findFrameCompressedSize(frame, frame_size);
  if (ZSTD_isError(used) || used != frame_size) {
    return absl::InvalidArgumentError("the compressed data is not one complete zstd frame");
  }
  if (const unsigned long long claimed = ZSTD_getFrameContentSize(frame, frame_size);
      claimed != content_size) {
    return absl::InvalidArgumentError(
        absl::StrCat("the compressed data claims another size than the ", content_size,
                     " bytes of the points it should hold"));
  }
  std::string content(content_size, '\0');
  const size_t size = ZSTD_decompress(content.data(), content.size(), frame, frame_size);
  if (ZSTD_isError(size) || size != content_size) {
    return absl::InvalidArgumentError("the compressed data is damaged");
  }
  return content;
}

absl::StatusOr<std::string> PackZstd(const std::string& content, int level) {
  std::string packed;
  AppendBytes(uint64_t{content.size()}, packed);
  if (absl::Status status = AppendZstdFrame(content, packed, level); !status.ok()) return status;
  return packed;
}

absl::StatusOr<std::string> UnpackZstd(const std::string& packed, uint64_t max_bytes) {
  ByteReader reader(packed);
  const auto size = reader.Read<uint64_t>();
  if (!reader.ok()) return absl::DataLossError("it is cut off");
  if (size > max_bytes) return absl::DataLossError("it claims to be larger than any is");
  const size_t at = packed.size() - reader.remaining();
  auto content = ReadZstdFrame(packed.data() + at, reader.remaining(), static_cast<size_t>(size));
  if (!content.ok()) return absl::DataLossError(content.status().message());
  return content;
}

}  // namespace isthmus::codec
