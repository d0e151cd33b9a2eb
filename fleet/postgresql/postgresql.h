// A connection to a PostgreSQL database, which finds a new way when it was lost.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "storage/sql/connection.h"

struct pg_conn;

namespace isthmus::storage {

class PostgresStatement;

struct PostgresTarget {
  std::string url;          // postgresql://...; see CheckPostgresUrl.
  std::string schema;       // The site's; everything is in it.
  std::string application;  // Shown by pg_stat_activity.
  bool sync_every_commit = true;
  // PostgreSQL takes a transaction back whose client says nothing for so long; 0: never.
  std::chrono::milliseconds idle_limit{0};
  // Nothing can be changed by it, and a PostgreSQL that only follows another one will do.
  bool is_read_only = false;
};

// InvalidArgument for a text that libpq cannot read as a URL, and for one with a password in it: it
// would be seen by `ps`, in the log and in the printed configuration.
absl::Status CheckPostgresUrl(const std::string& url);

// `name` as SQL text takes it.
std::string QuotedName(const std::string& name);

// A statement's changes are sent without waiting, many at a time (libpq's pipeline mode): see
// Statement::Run. Once the way was lost, the changes of its transaction are lost with it; the first
// statement after that connects anew, at most so often as limits.h says, in between it is
// Unavailable.
class PostgresConnection : public Connection {
 public:
  static absl::StatusOr<std::unique_ptr<PostgresConnection>> Open(const PostgresTarget& target);
  ~PostgresConnection() override;

  absl::Status Execute(const std::string& sql) override;
  bool InTransaction() const override { return in_transaction_; }
  bool IsLost() const override;
  const PostgresTarget& target() const { return target_; }
  // Counts connections: behind a new one may be a database that was set back.
  int64_t generation() const { return generation_; }

 protected:
  explicit PostgresConnection(PostgresTarget target);
  // Connects anew if the way was lost. Unavailable inside a transaction, which went with it.
  absl::Status EnsureConnected();
  // Time before the next attempt makes sense.
  std::chrono::steady_clock::duration PauseLeft() const;
  // Called with each new connection, before anything else; an error closes it again.
  virtual absl::Status Greet() { return absl::OkStatus(); }

  absl::Status BeginRead() override;
  absl::Status BeginWrite() override;
  absl::Status Commit() override;
  void Rollback() override;

 private:
  friend class PostgresStatement;
  absl::StatusOr<std::unique_ptr<CompiledStatement>> Compile(const std::string& sql) override;
  absl::Status Connect();
  absl::Status SetUp();
  void Close();

  // Sends the statement; its answer is read by Settle.
  absl::Status Send(PostgresStatement& statement);
  // Reads the answers to all that was sent. The first error among them.
  absl::Status Settle();
  absl::Status Lost();

  const PostgresTarget target_;
  pg_conn* connection_ = nullptr;
  int64_t generation_ = 0;  // Statements prepared on one are unknown to the next.
  int64_t prepared_ = 0;    // Counts names of prepared statements.
  bool in_transaction_ = false;
  bool is_broken_ = false;  // The way was lost inside a transaction that is still to be ended.
  // A message that was sent: a statement's preparation, or its execution.
  struct Sent {
    PostgresStatement* statement;
    bool is_preparation;
    bool is_wanted;  // Its answer is.
  };
  std::vector<Sent> sent_;
  std::unique_ptr<PostgresStatement> commit_;
  std::chrono::steady_clock::time_point next_attempt_ = {};
  std::chrono::milliseconds pause_{0};
  absl::Status last_failure_;
};

}  // namespace isthmus::storage
