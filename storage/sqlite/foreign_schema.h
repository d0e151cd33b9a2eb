// The search for tables, indices, triggers and views in a database that no migration made.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <vector>

#include "storage/sql/migration.h"
#include "storage/sqlite/sqlite.h"

namespace isthmus::storage {

// FailedPrecondition, naming it, for the first object of the schema that is not as the migrations
// up to `version` make it: a trigger or a view of somebody else runs whatever it likes as soon as a
// row is written or read. Comments, blanks and quotes make no difference, and missing objects are
// not looked for. Runs nothing that the database holds.
absl::Status CheckNothingForeign(SqliteConnection& database, int64_t version,
                                 const std::vector<Migration>& migrations);

}  // namespace isthmus::storage
