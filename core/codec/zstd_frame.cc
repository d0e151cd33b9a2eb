#include "core/codec/zstd_frame.h"

#include <absl/strings/str_cat.h>
#include <zstd.h>

#include <memory>

#include "core/byte_stream.h"

namespace isthmus::codec {

namespace {

// One context per thread: making one costs as much as a small frame. Null without memory.
ZSTD_CCtx* ThreadContext() {
  thread_local const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(),
                                                                                  &ZSTD_freeCCtx);
  return context.get();
}

absl::Status Failed(size_t code) {
  return absl::ResourceExhaustedError(absl::StrCat("zstd: ", ZSTD_getErrorName(code)));
}

// Appends one part, and the end of the frame behind the last one. Returns zstd's result.
size_t AppendPart(ZSTD_CCtx* context, absl::string_view part, bool last, ZSTD_outBuffer* out) {
  ZSTD_inBuffer in = {part.data(), part.size(), 0};
  size_t left = 1;
  while (left != 0 && !ZSTD_isError(left)) {
    left = ZSTD_compressStream2(context, out, &in, last ? ZSTD_e_end : ZSTD_e_flush);
    // The room suffices; were it not so, this would go on for ever.
    if (left != 0 && out->pos == out->size) return static_cast<size_t>(-1);
  }
  return left;
}

}  // namespace

absl::Status AppendZstdFrame(const std::string& content, std::string& out, int level) {
  ZSTD_CCtx* const context = ThreadContext();
  if (context == nullptr) return absl::ResourceExhaustedError("no memory to compress");
  const size_t start = out.size();
  out.resize(start + ZSTD_compressBound(content.size()));
  const size_t size = ZSTD_compressCCtx(context, out.data() + start, out.size() - start,
                                        content.data(), content.size(), level);
  if (ZSTD_isError(size)) {
    out.resize(start);
    return Failed(size);
  }
  out.resize(start + size);
  return absl::OkStatus();
}

absl::Status AppendZstdFrame(const std::vector<absl::string_view>& parts, std::string& out,
                             int level) {
  ZSTD_CCtx* const context = ThreadContext();
  if (context == nullptr) return absl::ResourceExhaustedError("no memory to compress");
  size_t size = 0;
  for (const absl::string_view part : parts) size += part.size();
  ZSTD_CCtx_reset(context, ZSTD_reset_session_and_parameters);
  ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, level);
  ZSTD_CCtx_setPledgedSrcSize(context, size);
  const size_t start = out.size();
  constexpr size_t kBlockHeader = 16;  // More than a block that a part ends early takes.
  out.resize(start + ZSTD_compressBound(size) + kBlockHeader * (parts.size() + 1));
  ZSTD_outBuffer buffer = {out.data() + start, out.size() - start, 0};
  for (size_t i = 0; i < parts.size(); ++i) {
    const size_t left = AppendPart(context, parts[i], i + 1 == parts.size(), &buffer);
    if (ZSTD_isError(left)) {
      out.resize(start);
      return Failed(left);
    }
  }
  out.resize(start + buffer.pos);
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
