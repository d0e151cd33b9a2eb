// Migrations of a site's tables in PostgreSQL.
#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

#include "storage/sql/connection.h"
#include "storage/sql/migration.h"

namespace isthmus::storage {

// The migrations in order of version, which counts without gaps; the table `about` holds it. From
// the first of fleet/postgresql/migrations/ on, those of storage/migrations/ by InPostgres, but for
// the ones that have a file of their number there.
const std::vector<Migration>& PostgresMigrations();
// The files of fleet/postgresql/migrations/.
const std::vector<Migration>& OwnPostgresMigrations();
// A migration of storage/migrations/ with PostgreSQL's types: INTEGER, REAL, TEXT and BLOB, in
// capitals behind a column's name, `key INTEGER PRIMARY KEY`, STRICT and WITHOUT ROWID are all that
// may differ. Stays as it is for what was released.
std::string InPostgres(const std::string& sql);

// Makes the schema of that name if it is missing, and brings its tables to the newest version, each
// migration in a transaction of its own. FailedPrecondition when it belongs to another program or
// is newer than the last migration; it is unchanged then. The connection finds names in this
// schema, and the caller sees to it that nobody else migrates it.
absl::Status MigratePostgres(Connection& database, const std::string& schema,
                             const std::vector<Migration>& migrations = PostgresMigrations());

// PermissionDenied where the role may not look into the schema. OK where there is none.
absl::Status CheckUsage(Connection& database, const std::string& schema);

// For a caller that does not own the site: OK where the schema has the newest version. Saying what
// to do, FailedPrecondition where it has another one and NotFound where it has no tables, or as
// CheckUsage; it is never changed.
absl::Status CheckMigrated(Connection& database, const std::string& schema);

}  // namespace isthmus::storage
