#include "storage/sqlite/migrations.h"

#include <absl/strings/str_cat.h>

#include "storage/sqlite/foreign_schema.h"

namespace isthmus::storage {
namespace {

constexpr char kReadVersion[] = "PRAGMA user_version";

absl::Status CheckOwner(SqliteConnection& database) {
  absl::StatusOr<int64_t> owner = database.ReadNumber("PRAGMA application_id");
  if (!owner.ok()) return owner.status();
  if (*owner == kApplicationId) return absl::OkStatus();
  absl::StatusOr<int64_t> objects = database.ReadNumber("SELECT count(*) FROM sqlite_schema");
  if (!objects.ok()) return objects.status();
  if (*owner == 0 && *objects == 0) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(database.path(), " is the database of another program; choose another folder"));
}

absl::Status Apply(SqliteConnection& database, const Migration& migration) {
  Transaction transaction(database);
  if (!transaction.status().ok()) return transaction.status();
  const std::string sql =
      absl::StrCat(migration.sql, ";\nPRAGMA user_version = ", migration.version,
                   ";\nPRAGMA application_id = ", kApplicationId, ";");
  if (absl::Status status = database.Execute(sql); !status.ok()) {
    return absl::Status(status.code(), absl::StrCat(migration.file, ": ", status.message()));
  }
  return transaction.Commit();
}

}  // namespace

absl::Status CheckSchema(SqliteConnection& database, const std::vector<Migration>& migrations) {
  if (absl::Status status = CheckOwner(database); !status.ok()) return status;
  absl::StatusOr<int64_t> version = database.ReadNumber(kReadVersion);
  if (!version.ok()) return version.status();
  absl::Status status = CheckVersion(database.path(), *version, migrations);
  if (status.ok()) status = CheckNothingForeign(database, *version, migrations);
  return status;
}

absl::Status Migrate(SqliteConnection& database, const std::vector<Migration>& migrations) {
  if (auto status = CheckSchema(database, migrations); !status.ok()) return status;
  absl::StatusOr<int64_t> version = database.ReadNumber(kReadVersion);
  if (!version.ok()) return version.status();
  for (const Migration& migration : migrations) {
    if (migration.version <= *version) continue;
    if (absl::Status status = Apply(database, migration); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace isthmus::storage
