// A step from one schema of a database to the next.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <cstdint>
#include <string>
#include <vector>

namespace isthmus::storage {

// A file of migrations, embedded when the program is built.
struct Migration {
  int64_t version = 0;  // The schema afterwards; one number means the same tables in all databases.
  const char* file = "";
  std::string sql;
};

// FailedPrecondition when `version`, of the database that `where` names, is newer than the last
// migration.
inline absl::Status CheckVersion(const std::string& where, int64_t version,
                                 const std::vector<Migration>& migrations) {
  const int64_t newest = migrations.empty() ? 0 : migrations.back().version;
  if (version <= newest) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat(where, " has schema ", version, ", written by a newer Isthmus; this one knows ",
                   newest, ": use the newer program, or another place"));
}

}  // namespace isthmus::storage
