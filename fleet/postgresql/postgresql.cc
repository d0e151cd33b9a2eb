#include "fleet/postgresql/postgresql.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>
#include <absl/strings/strip.h>
#include <libpq-fe.h>

#include <algorithm>

#include "fleet/postgresql/limits.h"
#include "fleet/postgresql/postgresql_statement.h"

namespace isthmus::storage {
namespace {

using Options = std::unique_ptr<PQconninfoOption, void (*)(PQconninfoOption*)>;
using Clock = std::chrono::steady_clock;

absl::StatusOr<Options> Parse(const std::string& url) {
  char* error = nullptr;
  Options options(PQconninfoParse(url.c_str(), &error), &PQconninfoFree);
  const std::string why = error == nullptr ? "" : error;
  PQfreemem(error);
  if (options == nullptr) {
    return absl::InvalidArgumentError(
        absl::StrCat("the store's URL cannot be read: ", absl::StripTrailingAsciiWhitespace(why)));
  }
  for (const PQconninfoOption* option = options.get(); option->keyword != nullptr; ++option) {
    if (std::string(option->keyword) != "password" || option->val == nullptr) continue;
    return absl::InvalidArgumentError(
        "leave the password out of the store's URL, where others can see it: put it into "
        "~/.pgpass, into a file that PGPASSFILE names, or into PGPASSWORD");
  }
  return options;
}

std::string MessageOf(PGconn* connection) {
  // libpq's message has several lines, with tabs.
  std::string message = absl::StrReplaceAll(PQerrorMessage(connection), {{"\n", " "}, {"\t", " "}});
  absl::RemoveExtraAsciiWhitespace(&message);
  return message;
}

}  // namespace

absl::Status CheckPostgresUrl(const std::string& url) { return Parse(url).status(); }

std::string QuotedName(const std::string& name) {
  return absl::StrCat("\"", absl::StrReplaceAll(name, {{"\"", "\"\""}}), "\"");
}

absl::StatusOr<std::unique_ptr<PostgresConnection>> PostgresConnection::Open(
    const PostgresTarget& target) {
  std::unique_ptr<PostgresConnection> connection(new PostgresConnection(target));
  if (absl::Status status = connection->EnsureConnected(); !status.ok()) return status;
  return connection;
}

PostgresConnection::PostgresConnection(PostgresTarget target)
    : target_(std::move(target)), commit_(std::make_unique<PostgresStatement>(*this, "COMMIT")) {}

PostgresConnection::~PostgresConnection() {
  ForgetStatements();
  Close();
}

void PostgresConnection::Close() {
  PQfinish(connection_);
  connection_ = nullptr;
  sent_.clear();
}

bool PostgresConnection::IsLost() const { return connection_ == nullptr; }

absl::Status PostgresConnection::Lost() {
  const std::string why = connection_ == nullptr ? "" : MessageOf(connection_);
  Close();
  is_broken_ = in_transaction_;
  in_transaction_ = false;
  next_attempt_ = Clock::now();
  pause_ = std::chrono::milliseconds(0);
  return absl::UnavailableError(absl::StrCat("the connection to PostgreSQL was lost: ", why));
}

Clock::duration PostgresConnection::PauseLeft() const {
  return std::max(next_attempt_ - Clock::now(), Clock::duration(0));
}

absl::Status PostgresConnection::EnsureConnected() {
  if (is_broken_) return absl::UnavailableError("the connection to PostgreSQL was lost");
  if (connection_ != nullptr) return absl::OkStatus();
  if (Clock::now() < next_attempt_) return last_failure_;
  absl::Status status = Connect();
  if (status.ok()) return status;
  Close();
  in_transaction_ = is_broken_ = false;
  pause_ = std::clamp(2 * pause_, kFirstPause, kLastPause);
  next_attempt_ = Clock::now() + pause_;
  last_failure_ = status;
  return status;
}

absl::Status PostgresConnection::Connect() {
  const absl::StatusOr<Options> given = Parse(target_.url);
  if (!given.ok()) return given.status();
  // libpq takes the last of several values for one key: the URL's own.
  const std::string connecting = absl::StrCat(kConnecting.count());
  const std::string silence_ms = absl::StrCat(1000 * kSilence.count());
  const std::string third = absl::StrCat(kSilence.count() / 3);
  std::vector<const char*> keys = {"connect_timeout",  "tcp_user_timeout",
                                   "keepalives_idle",  "keepalives_interval",
                                   "keepalives_count", "target_session_attrs"};
  std::vector<const char*> values = {connecting.c_str(),
                                     silence_ms.c_str(),
                                     third.c_str(),
                                     third.c_str(),
                                     "2",
                                     target_.is_read_only ? "any" : "read-write"};
  for (const PQconninfoOption* option = given->get(); option->keyword != nullptr; ++option) {
    if (option->val == nullptr) continue;
    keys.push_back(option->keyword);
    values.push_back(option->val);
  }
  for (const auto& [key, value] : {std::pair{"application_name", target_.application.c_str()},
                                   std::pair{"client_encoding", "UTF8"}}) {
    keys.push_back(key);
    values.push_back(value);
  }
  keys.push_back(nullptr);
  values.push_back(nullptr);
  connection_ = PQconnectdbParams(keys.data(), values.data(), 0);
  if (connection_ == nullptr) return absl::ResourceExhaustedError("no memory for a connection");
  if (PQstatus(connection_) != CONNECTION_OK) return absl::UnavailableError(MessageOf(connection_));
  ++generation_;
  // Notices are for people at a prompt.
  PQsetNoticeProcessor(
      connection_, [](void*, const char*) {}, nullptr);
  if (absl::Status status = SetUp(); !status.ok()) return status;
  if (absl::Status status = Greet(); !status.ok()) return status;
  pause_ = std::chrono::milliseconds(0);
  return absl::OkStatus();
}

absl::Status PostgresConnection::SetUp() {
  // The server lets go of a silent client, and of its locks, as soon as we do of a silent server.
  // A commit that may be lost with the power is for those who ask for it.
  const int64_t third = kSilence.count() / 3;
  return Execute(absl::StrCat(
      "SET search_path TO ", QuotedName(target_.schema), "; SET tcp_keepalives_idle TO ", third,
      "; SET tcp_keepalives_interval TO ", third, "; SET tcp_keepalives_count TO 2",
      "; SET tcp_user_timeout TO ", 1000 * kSilence.count(),
      "; SET standard_conforming_strings TO on; SET idle_in_transaction_session_timeout TO ",
      target_.idle_limit.count(),
      "; SET statement_timeout TO 0; SET default_transaction_isolation TO 'read committed'; ",
      target_.is_read_only ? "SET default_transaction_read_only TO on; " : "",
      target_.sync_every_commit ? "SELECT set_config('synchronous_commit', 'on', false) "
                                  "WHERE current_setting('synchronous_commit') = 'off'"
                                : "SET synchronous_commit TO off"));
}

absl::Status PostgresConnection::Execute(const std::string& sql) {
  if (absl::Status status = EnsureConnected(); !status.ok()) return status;
  absl::Status earlier = Settle();
  if (IsLost()) return earlier;
  PQexitPipelineMode(connection_);
  const Result result(PQexec(connection_, sql.c_str()));
  if (PQstatus(connection_) != CONNECTION_OK) return Lost();
  PQenterPipelineMode(connection_);
  return earlier.ok() ? StatusOf(result.get()) : earlier;
}

absl::StatusOr<std::unique_ptr<CompiledStatement>> PostgresConnection::Compile(
    const std::string& sql) {
  return std::make_unique<PostgresStatement>(*this, sql);
}

absl::Status PostgresConnection::Send(PostgresStatement& statement) {
  if (absl::Status status = EnsureConnected(); !status.ok()) return status;
  if (statement.prepared_on != generation_) {
    if (!statement.SendPreparation(connection_, absl::StrCat("s", ++prepared_))) return Lost();
    statement.prepared_on = generation_;
    sent_.push_back({&statement, true, false});
  }
  if (!statement.SendExecution(connection_)) return Lost();
  sent_.push_back({&statement, false, statement.wants_answer()});
  return sent_.size() < kSentAtOnce ? absl::OkStatus() : Settle();
}

absl::Status PostgresConnection::Settle() {
  if (sent_.empty()) return absl::OkStatus();
  if (PQpipelineSync(connection_) != 1) return Lost();
  absl::Status first;
  for (const Sent& sent : sent_) {
    Result answer(PQgetResult(connection_));
    if (PQstatus(connection_) != CONNECTION_OK || answer == nullptr) return Lost();
    absl::Status status = StatusOf(answer.get());
    if (!status.ok() && sent.is_preparation) sent.statement->prepared_on = 0;
    if (status.ok() && sent.is_wanted) status = sent.statement->Take(std::move(answer));
    if (first.ok()) first = status;
    while (PGresult* more = PQgetResult(connection_)) PQclear(more);
  }
  const Result end(PQgetResult(connection_));
  if (PQstatus(connection_) != CONNECTION_OK || end == nullptr) return Lost();
  sent_.clear();
  return first;
}

absl::Status PostgresConnection::BeginRead() {
  absl::Status status = Prepare("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY").Run();
  in_transaction_ = status.ok();
  return status;
}

absl::Status PostgresConnection::BeginWrite() {
  absl::Status status = Prepare("BEGIN").Run();
  in_transaction_ = status.ok();
  return status;
}

absl::Status PostgresConnection::Commit() {
  if (is_broken_) return absl::UnavailableError("the connection to PostgreSQL was lost");
  absl::Status status = commit_->Change().status();
  if (!status.ok()) return status;
  in_transaction_ = false;
  // A transaction in which something failed is taken back, without an error.
  if (commit_->Tag() == "COMMIT") return status;
  return absl::InternalError("PostgreSQL took the transaction back");
}

void PostgresConnection::Rollback() {
  is_broken_ = false;
  if (!in_transaction_) return;
  Settle().IgnoreError();  // An error in there would have PostgreSQL pass over the ROLLBACK.
  if (in_transaction_ && !Prepare("ROLLBACK").Change().ok() && !IsLost()) Close();
  in_transaction_ = is_broken_ = false;
}

}  // namespace isthmus::storage
