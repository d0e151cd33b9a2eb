// A connection to an SQL database, with statuses instead of codes and nothing to forget to release:
// the common part of the databases that keep maps.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace isthmus::storage {

// A statement as one database compiles it; Statement's promises are its duties. Parameters count
// from 1, columns from 0.
class CompiledStatement {
 public:
  virtual ~CompiledStatement() = default;
  virtual absl::Status BindNumber(int parameter, int64_t value) = 0;
  virtual absl::Status BindReal(int parameter, double value) = 0;
  virtual absl::Status BindText(int parameter, const std::string& text) = 0;
  virtual absl::Status BindBlob(int parameter, const std::string& bytes) = 0;
  virtual absl::Status BindNull(int parameter) = 0;
  virtual absl::StatusOr<bool> Step() = 0;
  virtual absl::Status Run() = 0;
  virtual absl::StatusOr<int64_t> Change() = 0;
  virtual void Reset() = 0;  // Forgets rows and parameters.
  virtual int64_t Int(int column) const = 0;
  virtual double Real(int column) const = 0;
  virtual bool IsNull(int column) const = 0;
  virtual std::string Text(int column) const = 0;
};

// A prepared statement at work: parameters first, in order, then rows. The first error sticks and
// comes back from Step, Run or Change, so that calls can be chained:
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

  // True when there is a row to read, false behind the last. DataLoss, naming the column, for a row
  // whose values are of other types than its tables', or NULL where these may not be.
  absl::StatusOr<bool> Step();
  // The results of `read` for each row, in order.
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
  // To the end, rows unread. Afterwards parameters can be bound anew. A database to which there is
  // a way may be told of it later, together with what follows: its error is then that of a later
  // Step, Change, Release or Commit, of whichever comes first.
  absl::Status Run();
  // As Run, but always at once; the rows that an INSERT, UPDATE or DELETE changed.
  absl::StatusOr<int64_t> Change();

  // Columns of the row, from 0.
  int64_t Int(int column) const { return compiled_->Int(column); }
  uint64_t Uint(int column) const { return static_cast<uint64_t>(Int(column)); }
  // 0 for a number that has not 32 bits, of which the next Step says that it is DataLoss.
  uint32_t Uint32(int column) const;
  double Real(int column) const;  // NaN for NULL.
  bool IsNull(int column) const { return compiled_->IsNull(column); }
  std::string Text(int column) const { return compiled_->Text(column); }  // For a blob, its bytes.

 private:
  friend class Connection;
  Statement(CompiledStatement* compiled, absl::Status status)
      : compiled_(compiled), status_(std::move(status)) {}
  Statement& Note(absl::Status status);

  CompiledStatement* compiled_;  // Owned by the connection's cache; reset when this goes.
  int bound_ = 0;
  mutable absl::Status status_;  // Also of values read.
};

// Not thread safe. Errors of the database become ResourceExhausted (disk or memory full), DataLoss
// (damaged), FailedPrecondition (cannot be written), Unavailable (busy, not to be reached, input or
// output errors), InvalidArgument (a value that it cannot take), Aborted (taken back for the sake
// of another's transaction, and worth another try) or Internal.
class Connection {
 public:
  virtual ~Connection() = default;
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Runs statements without parameters, parted by semicolons.
  virtual absl::Status Execute(const std::string& sql) = 0;
  // Compiled once per text, in which `?` stands for a parameter. A text must not be prepared again
  // while its statement is at work.
  Statement Prepare(const std::string& sql);
  // The first value of the first row, a number; 0 without rows.
  absl::StatusOr<int64_t> ReadNumber(const std::string& sql);
  // False outside, and after an error that took the open transaction back.
  virtual bool InTransaction() const = 0;
  // The way to the database was lost; the next user of the connection looks for a new one.
  virtual bool IsLost() const { return false; }

 protected:
  Connection() = default;
  // To be called before the database is closed.
  void ForgetStatements() { cache_.clear(); }

 private:
  friend class Transaction;
  virtual absl::StatusOr<std::unique_ptr<CompiledStatement>> Compile(const std::string& sql) = 0;
  virtual absl::Status BeginRead() = 0;
  virtual absl::Status BeginWrite() = 0;
  virtual absl::Status Commit() = 0;
  virtual void Rollback() = 0;

  std::map<std::string, std::unique_ptr<CompiledStatement>> cache_;
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
  // After an error nothing of the transaction has happened.
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
  // Makes the changes part of the transaction.
  absl::Status Release();

 private:
  Connection& database_;
  absl::Status status_;
  bool open_ = false;
};

}  // namespace isthmus::storage
