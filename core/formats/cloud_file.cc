#include "core/formats/cloud_file.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <filesystem>
#include <utility>

#include "core/formats/pcd.h"
#include "core/io/file_io.h"

namespace isthmus::formats {
namespace {

absl::StatusOr<PointPayload> ParsePcdPayload(const std::string& bytes) {
  absl::StatusOr<PcdFile> file = ParsePcd(bytes);
  if (!file.ok()) return file.status();
  return std::move(file->payload);
}

// Debian has no library for it.
absl::StatusOr<PointPayload> RefuseE57(const std::string&) {
  return absl::InvalidArgumentError(
      "E57 is not read by this program: convert it to .las or .ply first, with CloudCompare or "
      "PDAL");
}

using Parse = absl::StatusOr<PointPayload> (*)(const std::string&);

Parse ParserOf(const std::string& extension) {
  const std::string lower = absl::AsciiStrToLower(extension);
  if (lower == ".pcd") return ParsePcdPayload;
  if (lower == ".ply") return ParsePly;
  if (lower == ".las" || lower == ".laz") return ParseLas;
  if (lower == ".e57") return RefuseE57;
  return IsTextFile(lower) ? ParseText : nullptr;
}

}  // namespace

bool IsTextFile(const std::string& extension) {
  const std::string lower = absl::AsciiStrToLower(extension);
  return lower == ".csv" || lower == ".txt" || lower == ".xyz" || lower == ".asc" ||
         lower == ".pts";
}

bool IsCloudFile(const std::string& extension) { return ParserOf(extension) != nullptr; }

absl::StatusOr<PointPayload> ReadCloudFile(const std::string& path) {
  const Parse parse = ParserOf(std::filesystem::path(path).extension());
  if (parse == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": not a cloud that can be read: .pcd, .ply, .las or .csv"));
  }
  const absl::StatusOr<std::string> bytes = io::ReadFile(path);
  if (!bytes.ok()) return bytes.status();
  absl::StatusOr<PointPayload> payload = parse(*bytes);
  if (payload.ok()) return payload;
  return absl::Status(payload.status().code(),
                      absl::StrCat(path, ": ", payload.status().message()));
}

}  // namespace isthmus::formats
