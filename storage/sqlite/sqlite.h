// SQLite with statuses instead of codes, and nothing to forget to release.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace isthmus::storage {

// A prepared statement at work: parameters first, in order, then rows. The first error sticks and
// comes back from Step or Run, so that calls can be chained:
//   database.Prepare("INSERT INTO t VALUES (?, ?)").Bind(7).Bind("seven").Run();
// Must not outlive its connection. Not thread safe.
class Statement {
 public:
  ~Statement();
  Statement(Statement&& other) noexcept;
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  // Binds the next parameter; values are copied. Pairs of bytes are `BindBlob`'s, NaN is NULL.
  Statement& Bind(int64_t value);
  Statement& Bind(uint64_t value) { return Bind(static_cast<int64_t>(value)); }
  Statement& Bind(int value) { return Bind(int64_t{value}); }
  Statement& Bind(uint32_t value) { return Bind(int64_t{value}); }
  Statement& Bind(double value);
  Statement& Bind(const std::string& text);
  Statement& BindBlob(const std::string& bytes);
  Statement& BindNull();

  // True when there is a row to read, false behind the last.
  absl::StatusOr<bool> Step();
  // What `read` makes of each row, in order.
  template <typename Read>
  auto ReadAll(const Read& read) -> absl::StatusOr<std::vector<decltype(read(*this))>> {
    std::vector<decltype(read(*this))> records;
    while (true) {
      absl::StatusOr<bool> has_row = Step();
      if (!has_row.ok()) return has_row.status();
      if (!*has_row) return records;
      records.push_back(read(*this));
    }
  }
  // To the end, rows unread. Afterwards parameters can be bound anew.
  absl::Status Run();

  // Columns of the row, from 0.
  int64_t Int(int column) const;
  uint64_t Uint(int column) const { return static_cast<uint64_t>(Int(column)); }
  double Real(int column) const;  // NaN for NULL.
  bool IsNull(int column) const;
  std::string Text(int column) const;  // Of a BLOB, its bytes.

 private:
  friend class Connection;
  Statement(sqlite3* database, sqlite3_stmt* statement, absl::Status status)
      : database_(database), statement_(statement), status_(std::move(status)) {}
  Statement& Note(int code);

  sqlite3* const database_;
  sqlite3_stmt* statement_;  // Owned by the connection's cache; reset when this goes.
  int bound_ = 0;
  absl::Status status_;
};

// One connection. Not thread safe. Errors of SQLite become ResourceExhausted (disk or memory full),
// DataLoss (damaged file), FailedPrecondition (cannot be written), Unavailable (busy, input/output
// errors) or Internal.
class Connection {
 public:
  enum class Access { kCreate, kReadOnly };
  // kCreate makes the file if there is none; kReadOnly, which writes neither it nor its log, gives
  // Unavailable then.
  static absl::StatusOr<std::unique_ptr<Connection>> Open(const std::string& path,
                                                          Access access = Access::kCreate);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  const std::string& path() const { return path_; }
  // Runs statements without parameters, parted by semicolons.
  absl::Status Execute(const std::string& sql);
  // Compiled once per text. A text must not be prepared again while its statement is at work.
  Statement Prepare(const std::string& sql);
  // The first value of the first row, a number; 0 without rows.
  absl::StatusOr<int64_t> ReadNumber(const std::string& sql);
  // Rows that the last INSERT, UPDATE or DELETE changed; the key that the last INSERT made.
  int64_t Changes() const;
  int64_t LastKey() const;
  // Copies all of this database, as of one commit, over what `target` holds. Calls `progress`, if
  // any, with the share that is copied; Cancelled when it says false.
  absl::Status CopyTo(Connection& target, const std::function<bool(double)>& progress);
  // Sets whether the last connection that closes writes the log into the database; true at first.
  absl::Status SetCheckpointOnClose(bool checkpoint);
  // False outside, and after an error that took the open transaction back.
  bool InTransaction() const;

 private:
  Connection(std::string path, sqlite3* database) : path_(std::move(path)), database_(database) {}

  const std::string path_;
  sqlite3* const database_;
  std::map<std::string, sqlite3_stmt*> cache_;
};

// Rolled back when it goes out of scope without a successful Commit.
class Transaction {
 public:
  // kWrite takes the database's only writer's place at once, kRead fixes the snapshot that all
  // statements see.
  enum class Kind { kRead, kWrite };
  explicit Transaction(Connection& database, Kind kind = Kind::kWrite);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  // The status of BEGIN; nothing may be done unless OK.
  const absl::Status& status() const { return status_; }
  absl::Status Commit();

 private:
  Connection& database_;
  absl::Status status_;
  bool open_ = false;
};

// Part of an open transaction, taken back by itself when it goes out of scope without a successful
// Release. They do not nest.
class Savepoint {
 public:
  explicit Savepoint(Connection& database);
  ~Savepoint();
  Savepoint(const Savepoint&) = delete;
  Savepoint& operator=(const Savepoint&) = delete;

  // The status of BEGIN; nothing may be done unless OK.
  const absl::Status& status() const { return status_; }
  // Makes what was done part of the transaction.
  absl::Status Release();

 private:
  Connection& database_;
  absl::Status status_;
  bool open_ = false;
};

}  // namespace isthmus::storage
