#include "storage/upkeep/backup.h"

#include <absl/strings/str_cat.h>
#include <stdlib.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "core/io/append_file.h"
#include "core/io/folder.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/sqlite.h"

namespace isthmus::storage {
namespace {

namespace fs = std::filesystem;

absl::Status Copy(const std::string& from, const std::string& to, const BackupProgress& progress) {
  auto source = SqliteConnection::Open(from, SqliteConnection::Access::kReadOnly);
  if (!source.ok()) return source.status();
  if (absl::Status status = CheckSchema(**source); !status.ok()) return status;
  auto copy = SqliteConnection::Open(to);
  if (!copy.ok()) return copy.status();
  // Half a copy is thrown away, so nothing needs to be taken back.
  absl::Status status = (*copy)->Execute("PRAGMA journal_mode = OFF; PRAGMA synchronous = FULL");
  if (status.ok()) status = (*source)->CopyTo(**copy, progress);
  return status;
}

// Removes the files that reading the copy has left: an empty log and its index.
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
  std::string path = target + ".partial-XXXXXX";
  if (mkdtemp(path.data()) == nullptr) return io::FileError("write the backup", target, errno);
  io::PartFolder partial(path);
  const std::string to = partial.path() + "/isthmus.db";
  if (absl::Status status = Copy(from, to, progress); !status.ok()) return status;
  absl::StatusOr<StoreReport> report = CheckStore(partial.path());
  if (!report.ok()) return report.status();
  RemoveLog(to);
  const auto copy = io::AppendFile::OpenToRead(to);
  absl::Status status = copy.ok() ? (*copy)->Sync() : copy.status();
  if (status.ok()) status = partial.Become(target);
  if (!status.ok()) return status;
  return report;
}

}  // namespace isthmus::storage
