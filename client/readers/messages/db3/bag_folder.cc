#include "client/readers/messages/db3/bag_folder.h"

#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <tuple>
#include <utility>

#include "client/readers/messages/db3/bag_metadata.h"
#include "client/readers/messages/joined_file.h"
#include "client/readers/messages/limits.h"
#include "core/io/file_io.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadataName = "metadata.yaml";

bool IsBagPart(const std::string& name) {
  return absl::EndsWith(name, ".db3") || absl::EndsWith(name, ".mcap") ||
         absl::EndsWith(name, ".db3.zstd") || absl::EndsWith(name, ".mcap.zstd");
}

// drive_10.db3 comes after drive_9.db3.
std::vector<std::string> ListParts(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (IsBagPart(name) && entry.is_regular_file(error)) names.push_back(name);
  }
  const auto key = [](const std::string& name) {
    const std::string stem = name.substr(0, name.find('.'));
    const size_t digits = stem.find_last_not_of("0123456789") + 1;
    uint64_t number = 0;
    if (!absl::SimpleAtoi(absl::string_view(stem).substr(digits), &number)) number = 0;
    return std::make_tuple(stem.substr(0, digits), number, name);
  };
  std::sort(names.begin(), names.end(),
            [&](const std::string& a, const std::string& b) { return key(a) < key(b); });
  return names;
}

absl::StatusOr<BagMetadata> LoadMetadata(const fs::path& folder) {
  std::error_code error;
  const fs::path file = folder / kMetadataName;
  const auto size = fs::file_size(file, error);
  if (error) return absl::NotFoundError("the recording was not ended: there is no metadata.yaml");
  if (size > kMaxTextBytes) return absl::InvalidArgumentError("metadata.yaml is too large");
  absl::StatusOr<std::string> text = io::ReadFile(file);
  if (!text.ok()) return text.status();
  absl::StatusOr<BagMetadata> metadata = ParseBagMetadata(*text);
  if (metadata.ok()) return metadata;
  return absl::InvalidArgumentError(
      absl::StrCat("metadata.yaml cannot be read: ", metadata.status().message()));
}

absl::Status RefuseWhole(const std::string& folder) {
  return absl::InvalidArgumentError(absl::StrCat(
      "the files in ", folder, " are compressed as a whole; unpack them first, with `zstd -d ",
      folder, "/*.zstd`"));
}

}  // namespace

bool IsBagFolder(const std::string& path) {
  return LoadMetadata(path).ok() || !ListParts(path).empty();
}

absl::StatusOr<std::shared_ptr<const MessageFile>> OpenBagFolder(const std::string& path) {
  std::vector<std::string> notes;
  const absl::StatusOr<BagMetadata> metadata = LoadMetadata(path);
  if (!metadata.ok()) notes.push_back(std::string(metadata.status().message()));
  std::vector<std::string> names = metadata.ok() ? metadata->files : ListParts(path);
  if (names.empty()) names = ListParts(path);
  // Files that were unpacked have lost the ending.
  for (std::string& name : names) {
    std::error_code error;
    if (!absl::EndsWith(name, ".zstd")) continue;
    std::string unpacked = name.substr(0, name.rfind('.'));
    if (!fs::is_regular_file(fs::path(path) / unpacked, error)) return RefuseWhole(path);
    name = std::move(unpacked);
  }
  if (metadata.ok() && metadata->compression_mode == "MESSAGE" &&
      metadata->compression_format != "zstd") {
    return absl::InvalidArgumentError(absl::StrCat(
        "the messages in ", path, " are compressed with '", metadata->compression_format,
        "'; only zstd is read: convert the bag with `ros2 bag convert`"));
  }
  std::vector<std::shared_ptr<const MessageFile>> files;
  absl::Status first = absl::NotFoundError(absl::StrCat(path, " holds no .db3 and no .mcap files"));
  for (const std::string& name : names) {
    auto file = OpenMessageFile(fs::path(path) / name);
    if (file.ok()) {
      files.push_back(*std::move(file));
      continue;
    }
    if (files.empty() && absl::IsNotFound(first)) first = file.status();
    notes.push_back(absl::StrCat(name, " is left out: ", file.status().message()));
  }
  if (files.empty()) return first;
  std::string kind =
      absl::StartsWith(files.front()->kind(), "ROS 2") ? files.front()->kind() : "ROS 2 bag (MCAP)";
  return JoinFiles(std::move(files), std::move(kind), std::move(notes),
                   metadata.ok() ? metadata->messages : std::map<std::string, uint64_t>());
}

}  // namespace isthmus::readers
