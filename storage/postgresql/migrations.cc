#include "storage/postgresql/migrations.h"

#include <absl/strings/str_cat.h>

#include "storage/postgresql/postgresql.h"

namespace isthmus::storage {
namespace {

absl::StatusOr<bool> HasRow(Connection& database, const std::string& sql,
                            const std::string& parameter) {
  return database.Prepare(sql).Bind(parameter).Step();
}

// The version of the tables; 0 where there are none. Makes the schema.
absl::StatusOr<int64_t> FindVersion(Connection& database, const std::string& schema) {
  auto found = HasRow(database, "SELECT 1 FROM pg_namespace WHERE nspname = ?", schema);
  if (!found.ok()) return found.status();
  if (!*found) {
    const auto status = database.Execute(absl::StrCat("CREATE SCHEMA ", QuotedName(schema)));
    if (!status.ok()) return status;
  }
  constexpr char kTables[] =
      "SELECT 1 FROM pg_class c JOIN pg_namespace n ON n.oid = c.relnamespace WHERE nspname = ? "
      "AND relkind = 'r'";
  found = HasRow(database, absl::StrCat(kTables, " AND relname = 'about'"), schema);
  if (!found.ok()) return found.status();
  if (*found) return database.ReadNumber("SELECT version FROM about");
  found = HasRow(database, kTables, schema);
  if (!found.ok()) return found.status();
  if (!*found) return 0;
  return absl::FailedPreconditionError(
      absl::StrCat("the schema ", schema,
                   " holds tables of another program; choose another "
                   "database"));
}

// What is sent at once is one transaction.
absl::Status Apply(Connection& database, const Migration& migration) {
  const absl::Status status = database.Execute(absl::StrCat(
      "CREATE TABLE IF NOT EXISTS about (id BIGINT PRIMARY KEY CHECK (id = 1), "
      "version BIGINT NOT NULL);\n",
      migration.sql, ";\nINSERT INTO about (id, version) VALUES (1, ", migration.version,
      ") ON CONFLICT (id) DO UPDATE SET version = excluded.version"));
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(migration.file, ": ", status.message()));
}

}  // namespace

absl::Status MigratePostgres(Connection& database, const std::string& schema,
                             const std::vector<Migration>& migrations) {
  const absl::StatusOr<int64_t> version = FindVersion(database, schema);
  if (!version.ok()) return version.status();
  const auto known = CheckVersion(absl::StrCat("the schema ", schema), *version, migrations);
  if (!known.ok()) return known;
  for (const Migration& migration : migrations) {
    if (migration.version <= *version) continue;
    if (absl::Status status = Apply(database, migration); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status CheckIsNewest(Connection& database, const std::string& schema) {
  Statement row = database.Prepare(
      "SELECT 1 FROM pg_class c JOIN pg_namespace n ON n.oid = c.relnamespace WHERE nspname = ? "
      "AND relkind = 'r' AND relname = 'about'");
  const absl::StatusOr<bool> found = row.Bind(schema).Step();
  if (!found.ok()) return found.status();
  if (!*found) {
    return absl::NotFoundError(absl::StrCat("there is no site in the schema ", schema,
                                            " of that database yet; start its server first"));
  }
  const absl::StatusOr<int64_t> version = database.ReadNumber("SELECT version FROM about");
  if (!version.ok()) return version.status();
  const std::vector<Migration>& migrations = PostgresMigrations();
  if (absl::Status status = CheckVersion(absl::StrCat("the schema ", schema), *version, migrations);
      !status.ok()) {
    return status;
  }
  if (*version == migrations.back().version) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("the schema ", schema, " is of an older version, ", *version,
                   "; start its server with this version first, which brings it up to date"));
}

}  // namespace isthmus::storage
