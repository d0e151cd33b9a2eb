#include "client/readers/messages/db3/bag_database.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>
#include <sqlite3.h>

#include <filesystem>
#include <utility>

namespace isthmus::readers {
namespace {

absl::Status BagSqliteError(sqlite3* database) {
  const int code = sqlite3_errcode(database) & 0xFF;
  const std::string message =
      absl::StrCat("the database cannot be read: ", sqlite3_errmsg(database));
  return code == SQLITE_CORRUPT || code == SQLITE_NOTADB || code == SQLITE_ERROR
             ? absl::DataLossError(message)
             : absl::UnavailableError(message);
}

// A URI's path: what has a meaning in URIs is escaped.
std::string UriOf(const std::string& path) {
  std::error_code error;
  const std::string whole = std::filesystem::absolute(path, error).string();
  return absl::StrCat("file:",
                      absl::StrReplaceAll(whole, {{"%", "%25"}, {"?", "%3f"}, {"#", "%23"}}));
}

}  // namespace

BagQuery::BagQuery(BagQuery&& other) noexcept
    : statement_(std::exchange(other.statement_, nullptr)) {}

BagQuery& BagQuery::operator=(BagQuery&& other) noexcept {
  std::swap(statement_, other.statement_);
  return *this;
}

BagQuery::~BagQuery() { sqlite3_finalize(statement_); }

void BagQuery::Bind(int64_t value) { sqlite3_bind_int64(statement_, 1, value); }

absl::StatusOr<bool> BagQuery::Step() {
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return BagSqliteError(sqlite3_db_handle(statement_));
}

int64_t BagQuery::Int(int column) const { return sqlite3_column_int64(statement_, column); }

absl::string_view BagQuery::Bytes(int column) const {
  const void* bytes = sqlite3_column_blob(statement_, column);
  const int size = sqlite3_column_bytes(statement_, column);
  if (bytes == nullptr || size <= 0) return {};
  return {static_cast<const char*>(bytes), static_cast<size_t>(size)};
}

absl::StatusOr<std::unique_ptr<BagDatabase>> BagDatabase::OpenAs(const std::string& uri,
                                                                 bool with_log) {
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(
      uri.c_str(), &raw, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
  std::unique_ptr<BagDatabase> database(new BagDatabase(raw));
  if (raw == nullptr) return absl::ResourceExhaustedError("no memory to open the database");
  if (code != SQLITE_OK) return BagSqliteError(raw);
  if (with_log) {
    // The log is left as it is when the connection closes, and its index kept in memory.
    sqlite3_db_config(raw, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
    sqlite3_exec(raw, "PRAGMA locking_mode = EXCLUSIVE", nullptr, nullptr, nullptr);
  }
  // Nothing in the file may have anything executed but these queries.
  sqlite3_db_config(raw, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  absl::StatusOr<BagQuery> query = database->Query("SELECT count(*) FROM sqlite_master");
  if (!query.ok()) return query.status();
  if (absl::StatusOr<bool> row = query->Step(); !row.ok()) return row.status();
  return database;
}

absl::StatusOr<std::unique_ptr<BagDatabase>> BagDatabase::Open(const std::string& path,
                                                               bool* log_left_out) {
  *log_left_out = false;
  std::error_code error;
  const auto log_size = std::filesystem::file_size(path + "-wal", error);
  if (!error && log_size > 0) {
    auto with_log = OpenAs(UriOf(path) + "?mode=ro&vfs=unix-none", /*with_log=*/true);
    if (with_log.ok()) return with_log;
    *log_left_out = true;
  }
  return OpenAs(UriOf(path) + "?mode=ro&immutable=1", /*with_log=*/false);
}

BagDatabase::~BagDatabase() { sqlite3_close_v2(database_); }

absl::StatusOr<BagQuery> BagDatabase::Query(const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database_, sql.c_str(), -1, &statement, nullptr) != SQLITE_OK) {
    return BagSqliteError(database_);
  }
  return BagQuery(statement);
}

}  // namespace isthmus::readers
