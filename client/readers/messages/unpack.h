// The compressions of chunks and messages.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <optional>
#include <string>

namespace isthmus::readers {

// First bytes of frames.
inline constexpr absl::string_view kZstdMagic = "\x28\xB5\x2F\xFD";
inline constexpr absl::string_view kLz4Magic = "\x04\x22\x4D\x18";

enum class Compression : uint8_t {
  kNone,
  kBz2,   // bzip2, one stream.
  kLz4,   // LZ4 Frame Format 1.6.
  kZstd,  // RFC 8878, one frame.
};

// By the names that bags and MCAP give them ("none", "", "bz2", "lz4", "zstd"); empty for others.
std::optional<Compression> CompressionOf(absl::string_view name);

// Unpacks into `content`, which grows as it is filled, up to `claimed` bytes. InvalidArgument for
// claims above kMaxChunkBytes, DataLoss for data that are damaged or make another size, and
// OutOfRange where they end too early: then `content` is what could be unpacked.
absl::Status Unpack(Compression compression, absl::string_view packed, uint64_t claimed,
                    std::string* content);

// The message, unpacked into `content` where a recorder compressed each by itself (rosbag2's mode
// MESSAGE). The first bytes of a frame are no message of the encoding "cdr", and of the others none
// is compressed so. DataLoss for a frame that is damaged or makes more than kMaxChunkBytes.
absl::StatusOr<absl::string_view> UnpackedMessage(absl::string_view encoding,
                                                  absl::string_view bytes, std::string* content);

}  // namespace isthmus::readers
