// Migrations, which bring a new database or one of an older schema to the newest.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <vector>

#include "storage/sql/migration.h"
#include "storage/sqlite/sqlite.h"

namespace isthmus::storage {

// In the file's header, so that `file` and we know whose database it is: "ISTH".
inline constexpr int64_t kApplicationId = 0x49535448;

// The migrations of storage/migrations/ in order of version, which counts from 1 without gaps;
// PRAGMA user_version holds it.
const std::vector<Migration>& Migrations();

// FailedPrecondition when the database belongs to another program, has a schema that is newer than
// the last migration, or something in its schema that no migration made. Changes nothing.
absl::Status CheckSchema(SqliteConnection& database,
                         const std::vector<Migration>& migrations = Migrations());

// CheckSchema, then the migrations that are missing, each in a transaction of its own.
absl::Status Migrate(SqliteConnection& database,
                     const std::vector<Migration>& migrations = Migrations());

}  // namespace isthmus::storage
