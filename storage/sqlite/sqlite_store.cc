#include "storage/sqlite/sqlite_store.h"

#include <absl/strings/str_cat.h>

#include <cstdint>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/io/directory_lock.h"
#include "storage/sql/sql_store.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/open_marker.h"

namespace isthmus::storage {
namespace {

std::string DatabaseIn(const std::string& directory) { return directory + "/isthmus.db"; }

uint64_t BytesOf(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  return error ? 0 : size;
}

// Enough for a query, an export and a matcher at a time; more would wait for the disk anyway.
constexpr int kReaders = 3;

// Holds the folder's lock while a class that inherits it first has the database open.
class FolderHolder {
 protected:
  explicit FolderHolder(std::unique_ptr<io::DirectoryLock> lock) : lock_(std::move(lock)) {}

 private:
  const std::unique_ptr<io::DirectoryLock> lock_;
};

// In WAL mode readers see the last commit and wait for no writer.
class SqliteStore : FolderHolder, public SqlStore {
 public:
  SqliteStore(const std::string& directory, std::unique_ptr<io::DirectoryLock> lock,
              std::unique_ptr<Connection> writer, std::vector<std::unique_ptr<Connection>> readers,
              double resolution_m)
      : FolderHolder(std::move(lock)),
        SqlStore(std::move(writer), std::move(readers), resolution_m),
        path_(DatabaseIn(directory)),
        marker_(directory) {}

  StoreSize SizeOnDisk() const override { return {BytesOf(path_), BytesOf(path_ + "-wal")}; }

 private:
  const std::string path_;
  const OpenMarker marker_;  // Goes first.
};

// SQLite takes a database without a byte for a new one and throws its log away. None of ours is
// ever so: it was cut off, and the data to be rescued are in the log.
absl::Status CheckNotCutOff(const std::string& directory, const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size > 0) return absl::OkStatus();
  const std::uintmax_t log = std::filesystem::file_size(path + "-wal", error);
  if ((error || log == 0) && !OpenMarker::IsIn(directory)) return absl::OkStatus();
  return absl::DataLossError(
      absl::StrCat(path,
                   " is empty, but there was a map in it: it was cut off. Nothing was changed; "
                   "restore a backup, or move the folder away to begin a new map"));
}

absl::StatusOr<std::unique_ptr<SqliteConnection>> OpenConnection(const std::string& path,
                                                                 const std::string& pragmas) {
  auto connection = SqliteConnection::Open(path);
  if (!connection.ok()) return connection.status();
  if (absl::Status status = (*connection)->Execute(pragmas); !status.ok()) return status;
  return connection;
}

// Records that refer to one that is not there are in no list: somebody should know.
absl::Status NoteLostRecords(Connection& database, const SqliteOptions& options) {
  // The small tables, which are read on opening anyway.
  for (const char* table : {"sessions", "submaps", "matches", "verdicts", "loops", "anchors"}) {
    const auto lost = database.ReadNumber(
        absl::StrCat("SELECT count(*) FROM pragma_foreign_key_check('", table, "')"));
    if (!lost.ok()) return lost.status();
    if (*lost == 0 || !options.on_problem) continue;
    options.on_problem(absl::StrCat(*lost, " records of ", table, " belong to one that is not ",
                                    "there, and are left out: the map is damaged. ",
                                    "`isthmus-server --check` says what else is"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<MapStore>> OpenSqliteStore(const std::string& directory,
                                                          const SqliteOptions& options) {
  if (auto status = CheckResolution(options.resolution_m); !status.ok()) return status;
  absl::StatusOr<std::unique_ptr<io::DirectoryLock>> lock = io::DirectoryLock::Acquire(directory);
  if (!lock.ok()) return lock.status();
  const std::string path = DatabaseIn(directory);
  if (absl::Status status = CheckNotCutOff(directory, path); !status.ok()) return status;
  if (const std::string unfinished = UnfinishedCopy(directory); !unfinished.empty()) {
    return absl::FailedPreconditionError(unfinished);
  }
  const std::string missing = MissingLog(directory);
  if (!missing.empty() && options.on_problem) options.on_problem(missing);
  const bool had_log = BytesOf(path + "-wal") > 0;
  absl::StatusOr<std::unique_ptr<SqliteConnection>> writer = OpenConnection(path, "");
  if (!writer.ok()) return writer.status();
  // Before anything is changed, the journal mode and the log included.
  absl::Status status = (*writer)->SetCheckpointOnClose(false);
  if (status.ok()) status = CheckSchema(**writer);
  // A log that came of looking goes again; one that was there stays as it is.
  if (status.ok() || !had_log) status.Update((*writer)->SetCheckpointOnClose(true));
  if (!status.ok()) return status;
  constexpr char kWriterPragmas[] =
      "PRAGMA journal_mode = WAL; PRAGMA journal_size_limit = 67108864; PRAGMA foreign_keys = ON; "
      "PRAGMA temp_store = MEMORY; PRAGMA synchronous = ";
  const char* synchronous = options.sync_every_commit ? "FULL" : "NORMAL";
  status = (*writer)->Execute(absl::StrCat(kWriterPragmas, synchronous));
  if (status.ok()) status = Migrate(**writer);
  if (status.ok()) status = NoteLostRecords(**writer, options);
  if (!status.ok()) return status;
  // Begins the log anew, so that nothing of a torn end stays in it. It is as good with it.
  (*writer)->Execute("PRAGMA wal_checkpoint(TRUNCATE)").IgnoreError();
  std::vector<std::unique_ptr<Connection>> readers;
  for (int i = 0; i < kReaders; ++i) {
    auto reader = OpenConnection(path, "PRAGMA query_only = ON");
    if (!reader.ok()) return reader.status();
    readers.push_back(*std::move(reader));
  }
  return std::make_unique<SqliteStore>(directory, *std::move(lock), *std::move(writer),
                                       std::move(readers), options.resolution_m);
}

}  // namespace isthmus::storage
