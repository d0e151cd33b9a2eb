#include "client/library/spool/set_aside.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <filesystem>
#include <system_error>

#include "core/io/folder.h"
#include "core/io/part_file.h"

namespace isthmus::client {
namespace {

uint64_t BytesIn(const std::string& folder, const std::string& but) {
  uint64_t bytes = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const uint64_t size = entry.file_size(error);
    if (!error && entry.path() != but) bytes += size;
  }
  return bytes;
}

}  // namespace

absl::StatusOr<std::string> SetAside(const std::string& spool, int64_t stamp_ns,
                                     const std::string& scan, uint64_t most_bytes) {
  const std::string folder = absl::StrCat(spool, "/too-large");
  if (absl::Status status = io::MakeFolder(folder); !status.ok()) return status;
  const std::string path = absl::StrCat(folder, "/", stamp_ns, ".scan");
  if (BytesIn(folder, path) + scan.size() > most_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat(folder, " holds ", most_bytes, " bytes, as much as it may"));
  }
  if (absl::Status status = io::ReplaceFile(path, scan); !status.ok()) return status;
  return path;
}

}  // namespace isthmus::client
