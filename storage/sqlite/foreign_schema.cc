#include "storage/sqlite/foreign_schema.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>

namespace isthmus::storage {
namespace {

struct Object {
  std::string type, name;
  auto operator<=>(const Object&) const = default;
};
using Schema = std::map<Object, std::string>;  // The SQL that made each, normalised.

// Without comments, blanks and quotes, which versions of SQLite and of the migrations set
// differently; in small letters.
std::string Normalised(const std::string& sql) {
  std::string text;
  for (size_t i = 0; i < sql.size(); ++i) {
    if (sql.compare(i, 2, "--") == 0) {
      i = std::min(sql.find('\n', i), sql.size());
    } else if (!absl::ascii_isspace(static_cast<unsigned char>(sql[i])) && sql[i] != '"') {
      text += absl::ascii_tolower(static_cast<unsigned char>(sql[i]));
    }
  }
  return text;
}

absl::StatusOr<Schema> ReadSchema(SqliteConnection& database) {
  const auto objects =
      database.Prepare("SELECT type, name, coalesce(sql, '') FROM sqlite_schema")
          .ReadAll([](const Statement& row) {
            return std::pair(Object{row.Text(0), row.Text(1)}, Normalised(row.Text(2)));
          });
  if (!objects.ok()) return objects.status();
  return Schema(objects->begin(), objects->end());
}

absl::StatusOr<Schema> SchemaOf(int64_t version, const std::vector<Migration>& migrations) {
  auto database = SqliteConnection::Open(":memory:");
  if (!database.ok()) return database.status();
  for (const Migration& migration : migrations) {
    if (migration.version > version) continue;
    const absl::Status status = (*database)->Execute(migration.sql);
    if (!status.ok()) return status;
  }
  return ReadSchema(**database);
}

// SQLite's own: the index of a UNIQUE column has no SQL, and statistics are of ANALYZE.
bool IsOfSqlite(const Object& object, const std::string& sql) {
  if (object.type == "index" && sql.empty()) return true;
  return object.type == "table" && (object.name == "sqlite_sequence" ||
                                    object.name == "sqlite_stat1" || object.name == "sqlite_stat4");
}

}  // namespace

absl::Status CheckNothingForeign(SqliteConnection& database, int64_t version,
                                 const std::vector<Migration>& migrations) {
  const absl::StatusOr<Schema> found = ReadSchema(database);
  if (!found.ok()) return found.status();
  const absl::StatusOr<Schema> ours = SchemaOf(version, migrations);
  if (!ours.ok()) return ours.status();
  for (const auto& [object, sql] : *found) {
    const auto made = ours->find(object);
    if (made != ours->end() ? made->second == sql : IsOfSqlite(object, sql)) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        database.path(), ": the ", object.type, " ", object.name, " is not as Isthmus makes it in ",
        "schema ", version, ". Another program changed the database: restore a backup, or look at ",
        "it with sqlite3 and remove what is foreign"));
  }
  return absl::OkStatus();
}

}  // namespace isthmus::storage
