// A connection to a SQLite database.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <string>

#include "storage/sql/connection.h"

struct sqlite3;

namespace isthmus::storage {

class SqliteConnection : public Connection {
 public:
  enum class Access { kCreate, kReadOnly };
  // kCreate makes the file if there is none; kReadOnly, which writes neither it nor its log, gives
  // Unavailable then.
  static absl::StatusOr<std::unique_ptr<SqliteConnection>> Open(const std::string& path,
                                                                Access access = Access::kCreate);
  ~SqliteConnection() override;

  const std::string& path() const { return path_; }
  absl::Status Execute(const std::string& sql) override;
  bool InTransaction() const override;
  // Copies all of this database, as of one commit, over what `target` holds. Calls `progress`, if
  // any, with the share that is copied; Cancelled when it says false.
  absl::Status CopyTo(SqliteConnection& target, const std::function<bool(double)>& progress);
  // Sets whether the last connection that closes writes the log into the database; true at first.
  absl::Status SetCheckpointOnClose(bool checkpoint);

 private:
  SqliteConnection(std::string path, sqlite3* database)
      : path_(std::move(path)), database_(database) {}
  absl::StatusOr<std::unique_ptr<CompiledStatement>> Compile(const std::string& sql) override;
  absl::Status BeginRead() override { return Execute("BEGIN"); }
  absl::Status BeginWrite() override { return Execute("BEGIN IMMEDIATE"); }
  absl::Status Commit() override { return Execute("COMMIT"); }
  // Some errors have rolled back already, which makes this one fail; nothing is left to do then.
  void Rollback() override { Execute("ROLLBACK").IgnoreError(); }

  const std::string path_;
  sqlite3* const database_;
};

}  // namespace isthmus::storage
