#include "storage/upkeep/backup_stream.h"

#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <system_error>

namespace isthmus::storage {
namespace {

namespace fs = std::filesystem;

constexpr char kPrefix[] = "backup-";
constexpr size_t kPieceBytes = 1 << 20;

// Two at a time must not meet; those of a dead process may, so the process is in the name.
std::string NewFolder(const std::string& directory) {
  static std::atomic<int> count = 0;
  return absl::StrCat(directory, "/", kPrefix, getpid(), "-", ++count);
}

class FolderRemover {
 public:
  explicit FolderRemover(const std::string& path) : path_(path) {}
  ~FolderRemover() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  FolderRemover(const FolderRemover&) = delete;
  FolderRemover& operator=(const FolderRemover&) = delete;

 private:
  const std::string path_;
};

absl::Status HandOver(const std::string& path, const BackupReader& reader) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             &std::fclose);
  std::error_code error;
  const uint64_t size = fs::file_size(path, error);
  if (file == nullptr || error) {
    return absl::UnavailableError(absl::StrCat("cannot read the backup ", path));
  }
  if (reader.begin) reader.begin(size);
  std::string piece;
  uint64_t done = 0;
  while (done < size) {
    piece.resize(kPieceBytes);
    piece.resize(std::fread(piece.data(), 1, piece.size(), file.get()));
    if (piece.empty()) return absl::UnavailableError(absl::StrCat("cannot read ", path));
    if (!reader.piece(piece)) return absl::CancelledError("the backup was given up");
    done += piece.size();
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<StoreReport> StreamBackup(const std::string& directory, const BackupReader& reader) {
  const std::string folder = NewFolder(directory);
  const FolderRemover remover(folder);
  absl::StatusOr<StoreReport> report = BackUp(directory, folder, reader.progress);
  if (!report.ok()) return report.status();
  const absl::Status status = HandOver(folder + "/isthmus.db", reader);
  if (!status.ok()) return status;
  return report;
}

void RemoveAbandonedBackups(const std::string& directory) {
  std::error_code ignored;
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, ignored)) {
    if (entry.path().filename().string().rfind(kPrefix, 0) == 0) found.push_back(entry.path());
  }
  for (const fs::path& path : found) fs::remove_all(path, ignored);
}

}  // namespace isthmus::storage
