#include "storage/postgresql/site_writer.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "core/io/crc32c.h"
#include "storage/postgresql/limits.h"
#include "storage/postgresql/migrations.h"

namespace isthmus::storage {
namespace {

// "process 17 on robots-1".
std::string ThisProcess() {
  char host[256] = "";
  gethostname(host, sizeof(host) - 1);
  return absl::StrCat("process ", getpid(), " on ", host);
}

// Advisory locks are numbers, one for all of a database.
int64_t LockOf(const std::string& schema) {
  constexpr uint64_t kOurs = uint64_t{0x49535448} << 32;  // "ISTH".
  return static_cast<int64_t>(kOurs | io::Crc32c(schema.data(), schema.size()));
}

std::string LockTimeout(std::chrono::milliseconds timeout) {
  return absl::StrCat("SET lock_timeout TO ", timeout.count());
}

}  // namespace

SiteWriter::SiteWriter(PostgresTarget target, OnProblem on_problem)
    : PostgresConnection(std::move(target)),
      on_problem_(on_problem ? std::move(on_problem) : [](const std::string&) {}),
      me_(ThisProcess()) {}

absl::StatusOr<std::unique_ptr<SiteWriter>> SiteWriter::Open(const PostgresTarget& target,
                                                             OnProblem on_problem) {
  std::unique_ptr<SiteWriter> writer(new SiteWriter(target, std::move(on_problem)));
  if (absl::Status status = writer->EnsureConnected(); !status.ok()) return status;
  return writer;
}

absl::Status SiteWriter::Greet() {
  absl::Status status;
  if (epoch_ == 0) {
    status = CheckServer();
    if (status.ok()) status = TakeLock();
    if (status.ok()) status = MigratePostgres(*this, target().schema);
    if (status.ok()) status = TakeEpoch();
  } else {
    status = Return();
    if (status.ok()) status = TakeLock();
  }
  if (!status.ok()) return status;
  Statement row =
      Prepare("SELECT pid, backend_start::text FROM pg_stat_activity WHERE pid = pg_backend_pid()");
  const absl::StatusOr<bool> found = row.Step();
  if (!found.ok() || !*found) return found.status();
  backend_ = row.Int(0);
  backend_start_ = row.Text(1);
  return absl::OkStatus();
}

absl::Status SiteWriter::CheckServer() {
  Statement row = Prepare(
      "SELECT current_setting('server_encoding'), current_setting('fsync'), "
      "current_setting('full_page_writes')");
  const absl::StatusOr<bool> found = row.Step();
  if (!found.ok()) return found.status();
  if (row.Text(0) != "UTF8") {
    return absl::FailedPreconditionError(absl::StrCat(
        "the database is in ", row.Text(0),
        "; make one for Isthmus with `createdb --encoding UTF8 --template template0`"));
  }
  if (target().sync_every_commit && (row.Text(1) != "on" || row.Text(2) != "on")) {
    on_problem_(
        "PostgreSQL runs with fsync or full_page_writes off: a power cut may take all of the map");
  }
  return absl::OkStatus();
}

absl::Status SiteWriter::TakeLock() {
  absl::Status status = Execute(LockTimeout(kWaitForLock));
  if (!status.ok()) return status;
  status =
      Prepare("SELECT 1 FROM pg_advisory_lock(?)").Bind(LockOf(target().schema)).Step().status();
  if (status.ok()) return Execute(LockTimeout(std::chrono::milliseconds(0)));
  // Waiting has an end, which is an error of its own; others are what they say.
  return IsLost() || !absl::IsUnavailable(status) ? status : Refused("is open");
}

std::string SiteWriter::Holder() {
  Statement row = Prepare("SELECT holder, since_ns FROM owners WHERE is_current");
  const absl::StatusOr<bool> found = row.Step();
  if (!found.ok() || !*found) return "another process";
  return absl::StrCat(row.Text(0), " (since ",
                      absl::FormatTime("%Y-%m-%d %H:%M:%S UTC", absl::FromUnixNanos(row.Int(1)),
                                       absl::UTCTimeZone()),
                      ")");
}

absl::Status SiteWriter::Refused(const std::string& why) {
  const std::string message =
      absl::StrCat("the schema ", target().schema, " ", why, " in another server, ", Holder(),
                   ": one server at a time has a site");
  // To whoever has the store open already it is one that cannot be reached.
  return epoch_ == 0
             ? absl::FailedPreconditionError(message)
             : absl::UnavailableError(absl::StrCat(message, ". Stop this one, or that one"));
}

absl::Status SiteWriter::TakeEpoch() {
  if (auto status = PostgresConnection::BeginWrite(); !status.ok()) return status;
  // Waits for a transaction of the one before, if there is one still.
  absl::Status status = Prepare("UPDATE owners SET is_current = FALSE WHERE is_current").Run();
  Statement insert = Prepare(
      "INSERT INTO owners (holder, since_ns, last_commit, is_current) VALUES (?, ?, 0, TRUE) "
      "RETURNING epoch");
  insert.Bind(me_).Bind(absl::GetCurrentTimeNanos());
  if (status.ok()) status = insert.Step().status();
  if (!status.ok()) return status;
  const int64_t epoch = insert.Int(0);
  status = Prepare("DELETE FROM owners WHERE epoch <= ?").Bind(epoch - kOwnersKept).Run();
  if (status.ok()) status = PostgresConnection::Commit();
  if (status.ok()) epoch_ = epoch;
  return status;
}

absl::Status SiteWriter::Return() {
  // A server that is slow, not gone, may still be busy with what we sent: it is to end.
  absl::Status status = Prepare(
                            "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE "
                            "pid = ? AND backend_start::text = ?")
                            .Bind(backend_)
                            .Bind(backend_start_)
                            .Step()
                            .status();
  if (status.ok()) status = Execute(LockTimeout(kWaitForLock));
  if (!status.ok()) return status;
  // Waits for the transaction that has the row, which is our last one.
  Statement row = Prepare("SELECT last_commit, is_current FROM owners WHERE epoch = ? FOR UPDATE");
  const absl::StatusOr<bool> found = row.Bind(epoch_).Step();
  if (!found.ok()) return found.status();
  known_commit_ = *found ? row.Int(0) : 0;
  is_asked_ = true;
  if (!*found || known_commit_ < acknowledged_) {
    return absl::UnavailableError(
        absl::StrCat("PostgreSQL is back without what it had committed (restored from a backup, or "
                     "a replica that lacked it): restart this server to go on from there"));
  }
  return row.Int(1) != 0 ? absl::OkStatus() : Refused("was taken over");
}

absl::Status SiteWriter::BeginWrite() {
  const auto begin = [this]() -> absl::StatusOr<int64_t> {
    if (auto status = PostgresConnection::BeginWrite(); !status.ok()) return status;
    return Prepare("UPDATE owners SET last_commit = ? WHERE epoch = ? AND is_current")
        .Bind(commit_)
        .Bind(epoch_)
        .Change();
  };
  ++commit_;
  const bool was_connected = !IsLost();
  absl::StatusOr<int64_t> mine = begin();
  if (!mine.ok() && was_connected && IsLost()) {  // Before anything was done.
    Rollback();
    mine = begin();
  }
  if (mine.ok() && *mine == 1) return absl::OkStatus();
  Rollback();
  return mine.ok() ? Refused("was taken over") : mine.status();
}

absl::Status SiteWriter::Commit() {
  const bool may_have_begun = !IsLost();
  absl::Status status = PostgresConnection::Commit();
  if (!status.ok() && may_have_begun && IsLost()) status = FindOut(commit_);
  if (status.ok()) acknowledged_ = commit_;
  return status;
}

absl::Status SiteWriter::FindOut(int64_t commit) {
  on_problem_(
      "the connection to PostgreSQL was lost in the middle of a commit; nothing more is stored "
      "until it is back and tells whether that was done");
  Rollback();
  is_asked_ = false;
  while (true) {
    EnsureConnected().IgnoreError();
    if (is_asked_) break;
    std::this_thread::sleep_for(
        std::max<std::chrono::steady_clock::duration>(PauseLeft(), kFirstPause));
  }
  if (known_commit_ == commit) return absl::OkStatus();
  return absl::UnavailableError("the connection to PostgreSQL was lost before the commit");
}

}  // namespace isthmus::storage
