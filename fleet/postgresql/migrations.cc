#include "fleet/postgresql/migrations.h"

#include <absl/strings/str_cat.h>

#include "fleet/postgresql/postgresql.h"

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

// Statements that are sent at once are one transaction.
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

absl::Status CheckUsage(Connection& database, const std::string& schema) {
  const auto is_denied = HasRow(database,
                                "SELECT 1 FROM pg_namespace WHERE nspname = ? AND NOT "
                                "has_schema_privilege(oid, 'USAGE')",
                                schema);
  if (!is_denied.ok()) return is_denied.status();
  if (!*is_denied) return absl::OkStatus();
  return absl::PermissionDeniedError(absl::StrCat("the role may not look into the schema ", schema,
                                                  ": GRANT USAGE ON SCHEMA ", QuotedName(schema),
                                                  " to it, and what else docs/postgresql.md says"));
}

absl::Status CheckMigrated(Connection& database, const std::string& schema) {
  const std::string where = absl::StrCat("the schema ", schema);
  const auto is_there =
      database.ReadNumber("SELECT (to_regclass('about') IS NOT NULL)::int::bigint");
  if (!is_there.ok()) return is_there.status();
  if (*is_there == 0) {
    if (absl::Status status = CheckUsage(database, schema); !status.ok()) return status;
    return absl::NotFoundError(absl::StrCat(
        where, " holds no map: start the server that is to have it first, which makes the tables"));
  }
  const absl::StatusOr<int64_t> version = database.ReadNumber("SELECT version FROM about");
  if (!version.ok()) return version.status();
  const int64_t newest = PostgresMigrations().back().version;
  if (*version >= newest) return CheckVersion(where, *version, PostgresMigrations());
  return absl::FailedPreconditionError(absl::StrCat(
      where, " has schema ", *version, ", this program reads ", newest,
      ": start the server that has the map with this program first, which brings it there"));
}

}  // namespace isthmus::storage
