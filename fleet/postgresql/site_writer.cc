#include "fleet/postgresql/site_writer.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "fleet/postgresql/limits.h"
#include "fleet/postgresql/site_lease.h"

namespace isthmus::storage {

SiteWriter::SiteWriter(PostgresTarget target, int64_t epoch, OnProblem on_problem)
    : PostgresConnection(std::move(target)),
      epoch_(epoch),
      on_problem_(on_problem ? std::move(on_problem) : [](const std::string&) {}) {}

absl::StatusOr<std::unique_ptr<SiteWriter>> SiteWriter::Open(const PostgresTarget& target,
                                                             int64_t epoch, OnProblem on_problem) {
  std::unique_ptr<SiteWriter> writer(new SiteWriter(target, epoch, std::move(on_problem)));
  if (absl::Status status = writer->EnsureConnected(); !status.ok()) return status;
  return writer;
}

absl::Status SiteWriter::Greet() {
  if (backend_ != 0) {
    if (absl::Status status = Return(); !status.ok()) return status;
  }
  Statement row =
      Prepare("SELECT pid, backend_start::text FROM pg_stat_activity WHERE pid = pg_backend_pid()");
  const absl::StatusOr<bool> found = row.Step();
  if (!found.ok() || !*found) return found.status();
  backend_ = row.Int(0);
  backend_start_ = row.Text(1);
  return absl::OkStatus();
}

absl::Status SiteWriter::TakenOver() {
  return absl::UnavailableError(absl::StrCat("the schema ", target().schema,
                                             " was taken over in another server, ", OwnerOf(*this),
                                             ": one server at a time has a site"));
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
  const std::chrono::milliseconds longest = kWaitForLock;
  if (status.ok()) status = Execute(absl::StrCat("SET lock_timeout TO ", longest.count()));
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
  return row.Int(1) != 0 ? Execute("SET lock_timeout TO 0") : TakenOver();
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
  return mine.ok() ? TakenOver() : mine.status();
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
