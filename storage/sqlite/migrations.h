// Migrations, which bring a new database or one of an older schema to the newest.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <vector>

#include "storage/sqlite/sqlite.h"

namespace isthmus::storage {

// In the file's header, so that `file` and we know whose database it is: "ISTH".
inline constexpr int64_t kApplicationId = 0x49535448;

// A file of storage/migrations/, embedded when the program is built.
struct Migration {
  int64_t version = 0;  // Of the schema afterwards; PRAGMA user_version holds it.
  const char* file = "";
  const char* sql = "";
};

// In order of version, which counts from 1 without gaps.
const std::vector<Migration>& Migrations();

// FailedPrecondition when the database belongs to another program or has a schema that is newer
// than the last migration. Changes nothing.
absl::Status CheckSchema(SqliteConnection& database,
                         const std::vector<Migration>& migrations = Migrations());

// CheckSchema, then what is missing, each migration in a transaction of its own.
absl::Status Migrate(SqliteConnection& database,
                     const std::vector<Migration>& migrations = Migrations());

}  // namespace isthmus::storage
