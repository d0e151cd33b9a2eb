#include "client/readers/messages/unpack.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "client/readers/messages/limits.h"

namespace isthmus::readers {
namespace {

// The result of one step of a decompressor.
struct Unpacked {
  size_t read = 0, written = 0;
  bool ended = false;
  const char* error = nullptr;
};

// The size that the content has, or the most that it may have.
struct Size {
  uint64_t bytes = 0;
  bool is_exact = true;

  bool IsWrong(uint64_t filled, bool at_end) const {
    return filled > bytes || (is_exact && at_end && filled < bytes);
  }
  std::string Text() const {
    return is_exact ? absl::StrCat("another size than the ", bytes, " bytes said")
                    : absl::StrCat("more than ", bytes, " bytes");
  }
};

// Calls `step(in, out, room)` until the stream ends; `out` always has room for one byte beyond the
// size, so that more than that is found.
template <typename Step>
absl::Status RunUnpacker(absl::string_view packed, const Size& size, const Step& step,
                         std::string* content) {
  const uint64_t most = size.bytes + 1;
  size_t at = 0, filled = 0;
  content->resize(std::min<uint64_t>(most, (packed.size() + 1) * kFirstRoomRatio));
  absl::Status status;
  while (true) {
    if (filled == content->size()) content->resize(std::min<uint64_t>(most, 2 * filled));
    const Unpacked done =
        step(packed.substr(at), content->data() + filled, content->size() - filled);
    at += done.read;
    filled += done.written;
    const bool at_end = done.ended && at == packed.size();
    if (done.error != nullptr) {
      status = absl::DataLossError(absl::StrCat("the compressed data are damaged: ", done.error));
    } else if (size.IsWrong(filled, at_end)) {
      status = absl::DataLossError(absl::StrCat("the compressed data make ", size.Text()));
    } else if (!done.ended && done.read == 0 && done.written == 0) {
      status = absl::OutOfRangeError("the compressed data end too early");
    } else if (!at_end && (!done.ended || !size.is_exact || filled < size.bytes)) {
      continue;  // Another frame may follow.
    }
    content->resize(std::min<uint64_t>(filled, size.bytes));
    return status;
  }
}

absl::Status UnpackBz2(absl::string_view packed, const Size& size, std::string* content) {
  bz_stream stream = {};
  if (BZ2_bzDecompressInit(&stream, /*verbosity=*/0, /*small=*/0) != BZ_OK) {
    return absl::ResourceExhaustedError("no memory to unpack bz2");
  }
  constexpr size_t kMost = std::numeric_limits<unsigned>::max();
  absl::Status status = RunUnpacker(
      packed, size,
      [&](absl::string_view in, char* out, size_t room) {
        stream.next_in = const_cast<char*>(in.data());
        stream.avail_in = static_cast<unsigned>(std::min(in.size(), kMost));
        stream.next_out = out;
        stream.avail_out = static_cast<unsigned>(std::min(room, kMost));
        const unsigned in_before = stream.avail_in, out_before = stream.avail_out;
        const int code = BZ2_bzDecompress(&stream);
        return Unpacked{in_before - stream.avail_in, out_before - stream.avail_out,
                        code == BZ_STREAM_END,
                        code == BZ_OK || code == BZ_STREAM_END ? nullptr : "bz2"};
      },
      content);
  BZ2_bzDecompressEnd(&stream);
  return status;
}

absl::Status UnpackLz4(absl::string_view packed, const Size& size, std::string* content) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION))) {
    return absl::ResourceExhaustedError("no memory to unpack lz4");
  }
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      raw, &LZ4F_freeDecompressionContext);
  return RunUnpacker(
      packed, size,
      [&](absl::string_view in, char* out, size_t room) {
        size_t read = in.size(), written = room;
        const size_t code =
            LZ4F_decompress(context.get(), out, &written, in.data(), &read, nullptr);
        if (LZ4F_isError(code)) return Unpacked{0, 0, false, LZ4F_getErrorName(code)};
        // Zero bytes are asked for at the end of a frame, and of it alone.
        return Unpacked{read, written, code == 0};
      },
      content);
}

absl::Status UnpackZstdStream(absl::string_view packed, const Size& size, std::string* content) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(),
                                                                     &ZSTD_freeDCtx);
  if (context == nullptr) return absl::ResourceExhaustedError("no memory to unpack zstd");
  return RunUnpacker(
      packed, size,
      [&](absl::string_view in, char* out, size_t room) {
        ZSTD_inBuffer source = {in.data(), in.size(), 0};
        ZSTD_outBuffer sink = {out, room, 0};
        const size_t code = ZSTD_decompressStream(context.get(), &sink, &source);
        if (ZSTD_isError(code)) return Unpacked{0, 0, false, ZSTD_getErrorName(code)};
        return Unpacked{source.pos, sink.pos, code == 0};
      },
      content);
}

}  // namespace

std::optional<Compression> CompressionOf(absl::string_view name) {
  if (name.empty() || name == "none") return Compression::kNone;
  if (name == "bz2") return Compression::kBz2;
  if (name == "lz4") return Compression::kLz4;
  if (name == "zstd") return Compression::kZstd;
  return std::nullopt;
}

absl::Status Unpack(Compression compression, absl::string_view packed, uint64_t claimed,
                    std::string* content) {
  if (claimed > kMaxChunkBytes) {
    content->clear();
    return absl::InvalidArgumentError(
        absl::StrCat("a chunk claims ", claimed, " bytes; the limit is ", kMaxChunkBytes));
  }
  if (packed.empty() && claimed == 0) {
    content->clear();
    return absl::OkStatus();
  }
  switch (compression) {
    case Compression::kNone:
      content->assign(packed.data(), packed.size());
      break;
    case Compression::kBz2:
      return UnpackBz2(packed, {claimed}, content);
    case Compression::kLz4:
      return UnpackLz4(packed, {claimed}, content);
    case Compression::kZstd:
      return UnpackZstdStream(packed, {claimed}, content);
  }
  if (packed.size() == claimed) return absl::OkStatus();
  if (packed.size() < claimed) return absl::OutOfRangeError("the chunk ends too early");
  return absl::DataLossError(
      absl::StrCat("a chunk holds ", packed.size(), " bytes instead of ", claimed));
}

absl::StatusOr<absl::string_view> UnpackedMessage(absl::string_view encoding,
                                                  absl::string_view bytes, std::string* content) {
  const bool is_zstd = absl::StartsWith(bytes, kZstdMagic);
  if (encoding != "cdr" || !(is_zstd || absl::StartsWith(bytes, kLz4Magic))) return bytes;
  // Frames need not say their size: recorders that stream do not know it beforehand.
  const Size size{kMaxChunkBytes, false};
  const absl::Status status =
      is_zstd ? UnpackZstdStream(bytes, size, content) : UnpackLz4(bytes, size, content);
  if (!status.ok()) return absl::DataLossError(status.message());
  return absl::string_view(*content);
}

}  // namespace isthmus::readers
