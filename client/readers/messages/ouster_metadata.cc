#include "client/readers/messages/ouster_metadata.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "client/readers/messages/decode/place_message.h"
#include "client/readers/messages/limits.h"
#include "client/readers/messages/scan_topics.h"
#include "core/io/file_io.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;

size_t CommonLength(const std::string& a, const std::string& b) {
  return static_cast<size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first -
                             a.begin());
}

bool LooksLikeJson(const std::string& text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  return first != std::string::npos && text[first] == '{';
}

// The first JSON on that topic; empty where there is none.
std::string ReadJsonTopic(const MessageFile& file, size_t topic) {
  absl::StatusOr<std::unique_ptr<MessageReader>> reader = file.OpenReader({topic});
  if (!reader.ok()) return {};
  while (true) {
    absl::StatusOr<std::optional<Message>> message = (*reader)->Next();
    if (!message.ok()) continue;
    if (!message->has_value()) return {};
    absl::StatusOr<std::string> text =
        DecodeString(file.topics()[topic].encoding, (*message)->bytes);
    if (text.ok() && LooksLikeJson(*text)) return *std::move(text);
  }
}

std::optional<std::string> FindJsonBeside(const std::string& path) {
  std::error_code error;
  if (path.empty()) return std::nullopt;
  fs::path file = fs::absolute(path, error).lexically_normal();
  if (!file.has_filename()) file = file.parent_path();
  const fs::path same = fs::path(file).replace_extension(".json");
  if (fs::is_regular_file(same, error)) return same.string();
  std::vector<fs::path> folders = {file.parent_path()};
  if (fs::is_directory(file, error)) folders.insert(folders.begin(), file);
  for (const fs::path& folder : folders) {
    std::vector<std::string> found;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
      if (entry.path().extension() == ".json") found.push_back(entry.path().string());
    }
    if (found.size() == 1) return found.front();
  }
  return std::nullopt;
}

}  // namespace

absl::StatusOr<std::string> ReadTextFile(const std::string& path) {
  std::error_code error;
  if (const auto size = fs::file_size(path, error); !error && size > kMaxTextBytes) {
    return absl::InvalidArgumentError(absl::StrCat(path, " is too large to be a file of settings"));
  }
  return io::ReadFile(path);
}

absl::StatusOr<std::string> FindOusterMetadata(const MessageFile& file, const std::string& path,
                                               const std::string& topic,
                                               const std::string& metadata) {
  if (!metadata.empty()) return ReadTextFile(metadata);
  std::vector<std::pair<size_t, size_t>> nearest;  // Length in common; topic.
  for (size_t i = 0; i < file.topics().size(); ++i) {
    if (IsMetadataTopic(file.topics()[i])) {
      nearest.emplace_back(CommonLength(file.topics()[i].name, topic), i);
    }
  }
  std::sort(nearest.rbegin(), nearest.rend());
  for (const auto& [common, i] : nearest) {
    if (std::string json = ReadJsonTopic(file, i); !json.empty()) return json;
  }
  if (const std::optional<std::string> beside = FindJsonBeside(path)) return ReadTextFile(*beside);
  return absl::NotFoundError(
      absl::StrCat("the packets of ", topic,
                   " need the sensor's metadata, which are neither on a topic of the recording nor "
                   "in a .json beside it: give the JSON file"));
}

}  // namespace isthmus::readers
