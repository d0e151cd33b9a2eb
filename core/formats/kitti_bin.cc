#include "core/formats/kitti_bin.h"

#include <absl/strings/str_cat.h>

#include <limits>
#include <utility>

#include "core/io/file_io.h"

namespace isthmus::formats {

absl::StatusOr<PointPayload> ParseKittiBin(std::string bytes) {
  constexpr uint32_t kStride = 4 * sizeof(float);
  if (bytes.size() % kStride != 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("a KITTI scan is made of 16-byte points; ", bytes.size(),
                     " bytes are not a multiple of that: is the file truncated?"));
  }
  if (bytes.size() / kStride > std::numeric_limits<uint32_t>::max()) {
    return absl::InvalidArgumentError("a KITTI scan of more than 2^32 points");
  }
  PointPayload payload;
  payload.width = static_cast<uint32_t>(bytes.size() / kStride);
  payload.stride = kStride;
  payload.fields = {{"x", 0}, {"y", 4}, {"z", 8}, {"intensity", 12}};
  payload.data = std::move(bytes);
  return payload;
}

absl::StatusOr<PointPayload> ReadKittiBin(const std::string& path) {
  absl::StatusOr<std::string> bytes = io::ReadFile(path);
  if (!bytes.ok()) return bytes.status();
  absl::StatusOr<PointPayload> payload = ParseKittiBin(*std::move(bytes));
  if (payload.ok()) return payload;
  return absl::Status(payload.status().code(),
                      absl::StrCat(path, ": ", payload.status().message()));
}

}  // namespace isthmus::formats
