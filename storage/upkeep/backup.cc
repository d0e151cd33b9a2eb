#include "storage/upkeep/backup.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "storage/sqlite/migrations.h"
#include "storage/sqlite/sqlite.h"

namespace isthmus::storage {
namespace {

namespace fs = std::filesystem;

absl::Status CannotWrite(const std::string& path) {
  const std::string message =
      absl::StrCat("cannot write the backup ", path, ": ", std::strerror(errno));
  if (errno == ENOSPC || errno == EDQUOT) return absl::ResourceExhaustedError(message);
  return absl::FailedPreconditionError(message);
}

// A folder that goes again unless it becomes the target.
class PartialFolder {
 public:
  explicit PartialFolder(const std::string& target)
      : path_(target + ".partial-XXXXXX"), is_made_(mkdtemp(path_.data()) != nullptr) {}
  ~PartialFolder() {
    std::error_code ignored;
    if (is_made_) fs::remove_all(path_, ignored);
  }
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;

  const std::string& path() const { return path_; }
  bool is_made() const { return is_made_; }
  absl::Status Become(const std::string& target) {
    if (std::rename(path_.c_str(), target.c_str()) != 0) return CannotWrite(target);
    is_made_ = false;
    return absl::OkStatus();
  }

 private:
  std::string path_;
  bool is_made_;
};

// The names in a folder are on the disk only once it is synced itself.
absl::Status Sync(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return CannotWrite(path);
  const bool is_synced = fsync(descriptor) == 0;
  const absl::Status status = is_synced ? absl::OkStatus() : CannotWrite(path);
  close(descriptor);
  return status;
}

absl::Status Copy(const std::string& from, const std::string& to, const BackupProgress& progress) {
  auto source = Connection::Open(from, Connection::Access::kReadOnly);
  if (!source.ok()) return source.status();
  if (absl::Status status = CheckSchema(**source); !status.ok()) return status;
  auto copy = Connection::Open(to);
  if (!copy.ok()) return copy.status();
  // Half a copy is thrown away, so nothing needs to be taken back.
  absl::Status status = (*copy)->Execute("PRAGMA journal_mode = OFF; PRAGMA synchronous = FULL");
  if (status.ok()) status = (*source)->CopyTo(**copy, progress);
  return status;
}

// Removes what reading the copy has left: an empty log and its index.
void RemoveLog(const std::string& database) {
  std::error_code ignored;
  fs::remove(database + "-shm", ignored);
  if (fs::file_size(database + "-wal", ignored) == 0) fs::remove(database + "-wal", ignored);
}

}  // namespace

absl::StatusOr<StoreReport> BackUp(const std::string& directory, const std::string& target,
                                   const BackupProgress& progress) {
  const std::string from = directory + "/isthmus.db";
  std::error_code ignored;
  if (!fs::exists(from, ignored)) {
    return absl::NotFoundError(absl::StrCat("there is no map: ", from, " does not exist"));
  }
  if (fs::exists(target, ignored)) {
    return absl::AlreadyExistsError(
        absl::StrCat(target, " exists already; a backup makes its own folder"));
  }
  PartialFolder partial(target);
  if (!partial.is_made()) return CannotWrite(target);
  const std::string to = partial.path() + "/isthmus.db";
  if (absl::Status status = Copy(from, to, progress); !status.ok()) return status;
  absl::StatusOr<StoreReport> report = CheckStore(partial.path());
  if (!report.ok()) return report.status();
  RemoveLog(to);
  absl::Status status = Sync(to);
  if (status.ok()) status = Sync(partial.path());
  if (status.ok()) status = partial.Become(target);
  if (status.ok()) status = Sync(fs::absolute(target).lexically_normal().parent_path().string());
  if (!status.ok()) return status;
  return report;
}

}  // namespace isthmus::storage
