#include "core/io/folder.h"

#include <absl/strings/numbers.h>
#include <absl/strings/strip.h>
#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

namespace isthmus::io {

namespace fs = std::filesystem;

absl::Status SyncFolder(const std::string& path, const DiskCalls& disk) {
  const auto folder = File::Open(path.empty() ? "." : path, O_RDONLY | O_DIRECTORY, disk);
  if (!folder.ok()) return folder.status();
  if (disk.sync_folder(folder->descriptor()) == 0) return absl::OkStatus();
  return FileError("sync", path, errno);
}

absl::Status SyncNameOf(const std::string& path) {
  return SyncFolder(fs::absolute(path).lexically_normal().parent_path().string());
}

absl::Status MakeFolder(const std::string& path, const DiskCalls& disk) {
  std::error_code error;
  if (path.empty() || fs::is_directory(path, error)) return absl::OkStatus();
  const std::string parent = fs::path(path).parent_path().string();
  if (absl::Status status = MakeFolder(parent, disk); !status.ok()) return status;
  fs::create_directory(path, error);
  return error ? FileError("make", path, error.value()) : SyncFolder(parent, disk);
}

absl::StatusOr<std::vector<uint64_t>> ListNumbers(const std::string& folder,
                                                  const std::string& suffix) {
  std::vector<uint64_t> numbers;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    absl::string_view digits = name;
    uint64_t number = 0;
    if (absl::ConsumeSuffix(&digits, suffix) && absl::SimpleAtoi(digits, &number) && number > 0) {
      numbers.push_back(number);
    }
  }
  if (error) return FileError("list", folder, error.value());
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

PartFolder::~PartFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

absl::Status PartFolder::Become(const std::string& target) {
  if (absl::Status status = SyncFolder(path_); !status.ok()) return status;
  if (std::rename(path_.c_str(), target.c_str()) != 0) return FileError("make", target, errno);
  path_.clear();
  return SyncNameOf(target);
}

}  // namespace isthmus::io
