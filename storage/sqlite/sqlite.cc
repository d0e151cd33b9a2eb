#include "storage/sqlite/sqlite.h"

#include <absl/strings/str_cat.h>
#include <sqlite3.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <utility>
#include <vector>

namespace isthmus::storage {
namespace {

// The system's error at the last failed access to the database file or to its journal.
int LastErrno(sqlite3* database, int which_file) {
  sqlite3_file* file = nullptr;
  int error = 0;
  if (sqlite3_file_control(database, "main", which_file, &file) == SQLITE_OK && file != nullptr &&
      file->pMethods != nullptr) {
    file->pMethods->xFileControl(file, SQLITE_FCNTL_LAST_ERRNO, &error);
  }
  return error;
}

// A quota or a limit on file sizes reaches SQLite as an error of writing, not as a full disk; and
// so does the index of the log, which only grows by being written to, for want of any space.
bool IsDiskFull(sqlite3* database, int code) {
  if (code == SQLITE_FULL || code == SQLITE_IOERR_SHMSIZE) return true;
  if (code != SQLITE_IOERR_WRITE) return false;
  for (const int which : {SQLITE_FCNTL_JOURNAL_POINTER, SQLITE_FCNTL_FILE_POINTER}) {
    const int error = LastErrno(database, which);
    if (error == ENOSPC || error == EDQUOT || error == EFBIG) return true;
  }
  return false;
}

absl::Status ToStatus(sqlite3* database, int code) {
  if (code == SQLITE_OK || code == SQLITE_ROW || code == SQLITE_DONE) return absl::OkStatus();
  const char* name = database == nullptr ? nullptr : sqlite3_db_filename(database, "main");
  const std::string file = name == nullptr ? "SQLite" : name;
  if (IsDiskFull(database, code)) {
    return absl::ResourceExhaustedError(
        absl::StrCat(file, ": its disk is full; free some space on it"));
  }
  const std::string message = absl::StrCat(
      file, ": ", database == nullptr ? sqlite3_errstr(code) : sqlite3_errmsg(database));
  switch (code & 0xFF) {
    case SQLITE_NOMEM:
      return absl::ResourceExhaustedError(message);
    case SQLITE_TOOBIG:
      return absl::InvalidArgumentError(message);
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::DataLossError(absl::StrCat(message, "; restore a backup"));
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      return absl::FailedPreconditionError(message);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
      return absl::UnavailableError(message);
    default:
      return absl::InternalError(message);
  }
}

// The schema's declaration of a column of a table, and so of a column of a statement.
struct DeclaredColumn {
  int type = SQLITE_NULL;  // SQLITE_NULL: of any.
  bool may_be_null = true;
  std::string name;  // "sessions.robot"
};

int TypeOf(const std::string& declared) {
  if (declared == "INTEGER") return SQLITE_INTEGER;
  if (declared == "REAL") return SQLITE_FLOAT;
  if (declared == "TEXT") return SQLITE_TEXT;
  return declared == "BLOB" ? SQLITE_BLOB : SQLITE_NULL;
}

// The declaration of a column; nothing is declared of an expression.
DeclaredColumn DeclarationOf(sqlite3* database, sqlite3_stmt* statement, int column) {
  const char* table = sqlite3_column_table_name(statement, column);
  const char* name = sqlite3_column_origin_name(statement, column);
  const char* type = nullptr;
  int not_null = 0;
  if (table == nullptr || name == nullptr ||
      sqlite3_table_column_metadata(database, nullptr, table, name, &type, nullptr, &not_null,
                                    nullptr, nullptr) != SQLITE_OK) {
    return {};
  }
  return {TypeOf(type == nullptr ? "" : type), not_null == 0, absl::StrCat(table, ".", name)};
}

const char* NameOfType(int type) {
  switch (type) {
    case SQLITE_INTEGER:
      return "INTEGER";
    case SQLITE_FLOAT:
      return "REAL";
    case SQLITE_TEXT:
      return "TEXT";
    case SQLITE_BLOB:
      return "BLOB";
    default:
      return "NULL";
  }
}

// Tables are STRICT, so SQLite writes nothing else; a value that was damaged or changed behind its
// back it reads as it is.
class SqliteStatement : public CompiledStatement {
 public:
  SqliteStatement(sqlite3* database, sqlite3_stmt* statement)
      : database_(database), statement_(statement) {
    for (int i = 0; i < sqlite3_column_count(statement); ++i) {
      columns_.push_back(DeclarationOf(database, statement, i));
    }
  }
  ~SqliteStatement() override { sqlite3_finalize(statement_); }
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;

  absl::Status BindNumber(int parameter, int64_t value) override {
    return ToStatus(database_, sqlite3_bind_int64(statement_, parameter, value));
  }
  absl::Status BindReal(int parameter, double value) override {
    return ToStatus(database_, sqlite3_bind_double(statement_, parameter, value));
  }
  absl::Status BindText(int parameter, const std::string& text) override {
    return ToStatus(database_, sqlite3_bind_text64(statement_, parameter, text.data(), text.size(),
                                                   SQLITE_TRANSIENT, SQLITE_UTF8));
  }
  absl::Status BindBlob(int parameter, const std::string& bytes) override {
    return ToStatus(database_, sqlite3_bind_blob64(statement_, parameter, bytes.data(),
                                                   bytes.size(), SQLITE_TRANSIENT));
  }
  absl::Status BindNull(int parameter) override {
    return ToStatus(database_, sqlite3_bind_null(statement_, parameter));
  }

  absl::StatusOr<bool> Step() override {
    const int code = sqlite3_step(statement_);
    if (code == SQLITE_DONE) return false;
    if (code != SQLITE_ROW) return ToStatus(database_, code);
    if (absl::Status status = CheckRow(); !status.ok()) return status;
    return true;
  }
  absl::Status Run() override {
    while (true) {
      absl::StatusOr<bool> has_row = Step();
      if (!has_row.ok()) return has_row.status();
      if (!*has_row) break;
    }
    sqlite3_reset(statement_);
    return absl::OkStatus();
  }
  absl::StatusOr<int64_t> Change() override {
    if (absl::Status status = Run(); !status.ok()) return status;
    return sqlite3_changes64(database_);
  }
  void Reset() override {
    sqlite3_reset(statement_);
    sqlite3_clear_bindings(statement_);
  }

  int64_t Int(int column) const override { return sqlite3_column_int64(statement_, column); }
  double Real(int column) const override { return sqlite3_column_double(statement_, column); }
  bool IsNull(int column) const override {
    return sqlite3_column_type(statement_, column) == SQLITE_NULL;
  }
  std::string Text(int column) const override {
    const void* bytes = sqlite3_column_blob(statement_, column);
    const int size = sqlite3_column_bytes(statement_, column);
    if (bytes == nullptr) return {};
    return std::string(static_cast<const char*>(bytes), static_cast<size_t>(size));
  }

 private:
  // DataLoss for a value of another type than its column's.
  absl::Status CheckRow() const {
    for (size_t i = 0; i < columns_.size(); ++i) {
      const int type = sqlite3_column_type(statement_, static_cast<int>(i));
      const DeclaredColumn& column = columns_[i];
      if (type == SQLITE_NULL ? column.may_be_null
                              : column.type == SQLITE_NULL || column.type == type) {
        continue;
      }
      return absl::DataLossError(absl::StrCat(
          sqlite3_db_filename(database_, "main"), ": ", column.name, " is ", NameOfType(type),
          " in a row, and must be ", NameOfType(column.type),
          ": the file is damaged, or another program changed it. `isthmus-server --check` says "
          "what else is; restore a backup"));
    }
    return absl::OkStatus();
  }

  sqlite3* const database_;
  sqlite3_stmt* const statement_;
  std::vector<DeclaredColumn> columns_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteConnection>> SqliteConnection::Open(const std::string& path,
                                                                         Access access) {
  sqlite3* database = nullptr;
  const int how = access == Access::kReadOnly ? SQLITE_OPEN_READONLY
                                              : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  // No mutex of SQLite's own: the holder of a connection guards it.
  const int code = sqlite3_open_v2(path.c_str(), &database, how | SQLITE_OPEN_NOMUTEX, nullptr);
  std::unique_ptr<SqliteConnection> connection(new SqliteConnection(path, database));
  if (code != SQLITE_OK) return ToStatus(database, code);
  sqlite3_extended_result_codes(database, 1);
  constexpr int kWaitForOthers_ms = 5000;  // The sqlite3 shell may be looking at the file.
  sqlite3_busy_timeout(database, kWaitForOthers_ms);
  if (access == Access::kCreate) return connection;
  if (auto status = connection->SetCheckpointOnClose(false); !status.ok()) return status;
  return connection;
}

SqliteConnection::~SqliteConnection() {
  ForgetStatements();
  sqlite3_close(database_);
}

absl::Status SqliteConnection::Execute(const std::string& sql) {
  return ToStatus(database_, sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr));
}

absl::StatusOr<std::unique_ptr<CompiledStatement>> SqliteConnection::Compile(
    const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v3(database_, sql.data(), static_cast<int>(sql.size()),
                                      SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
  if (code != SQLITE_OK) return ToStatus(database_, code);
  return std::make_unique<SqliteStatement>(database_, statement);
}

absl::Status SqliteConnection::SetCheckpointOnClose(bool checkpoint) {
  return ToStatus(database_, sqlite3_db_config(database_, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE,
                                               checkpoint ? 0 : 1, nullptr));
}

absl::Status SqliteConnection::CopyTo(SqliteConnection& target,
                                      const std::function<bool(double)>& progress) {
  constexpr int kPagesAtOnce = 64;
  // Held throughout: the copy would else begin anew with every commit of others.
  const Transaction snapshot(*this, Transaction::Kind::kRead);
  if (!snapshot.status().ok()) return snapshot.status();
  Statement first = Prepare("SELECT count(*) FROM sqlite_schema");
  if (auto row = first.Step(); !row.ok()) return row.status();
  sqlite3_backup* backup = sqlite3_backup_init(target.database_, "main", database_, "main");
  if (backup == nullptr) return ToStatus(target.database_, sqlite3_errcode(target.database_));
  int code = SQLITE_OK;
  bool goes_on = true;
  while (code == SQLITE_OK && goes_on) {
    code = sqlite3_backup_step(backup, kPagesAtOnce);
    const double all = std::max(1, sqlite3_backup_pagecount(backup));
    if (progress && code == SQLITE_OK)
      goes_on = progress(1 - sqlite3_backup_remaining(backup) / all);
  }
  const int finished = sqlite3_backup_finish(backup);
  if (!goes_on) return absl::CancelledError("the copy was given up");
  if (finished != SQLITE_OK) return ToStatus(target.database_, finished);
  if (code == SQLITE_DONE) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(path_, ": ", sqlite3_errstr(code)));
}

bool SqliteConnection::InTransaction() const { return sqlite3_get_autocommit(database_) == 0; }

}  // namespace isthmus::storage
