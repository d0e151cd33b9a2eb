#include "fleet/postgresql/site_lease.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "core/caught.h"
#include "core/concurrency/thread_role.h"
#include "core/io/crc32c.h"
#include "fleet/postgresql/migrations.h"

namespace isthmus::storage {
namespace {

// "process 17 on robots-1".
std::string ThisProcess() {
  char host[256] = "";
  gethostname(host, sizeof(host) - 1);
  return absl::StrCat("process ", getpid(), " on ", host);
}

// Advisory locks are two numbers, of all of a database: these name the program and the schema.
constexpr int64_t kOurs = 0x49535448;  // Format: "ISTH".

int64_t LockOf(const std::string& schema) { return io::Crc32c(schema.data(), schema.size()); }

absl::Status CheckServer(PostgresConnection& database,
                         const std::function<void(const std::string&)>& on_problem) {
  Statement row = database.Prepare(
      "SELECT current_setting('server_encoding'), current_setting('fsync'), "
      "current_setting('full_page_writes')");
  const absl::StatusOr<bool> found = row.Step();
  if (!found.ok()) return found.status();
  if (row.Text(0) != "UTF8") {
    return absl::FailedPreconditionError(absl::StrCat(
        "the database is in ", row.Text(0),
        "; make one for Isthmus with `createdb --encoding UTF8 --template template0`"));
  }
  const bool is_safe = row.Text(1) == "on" && row.Text(2) == "on";
  if (database.target().sync_every_commit && !is_safe && on_problem) {
    on_problem(
        "PostgreSQL runs with fsync or full_page_writes off: a power cut may take all of the map");
  }
  return absl::OkStatus();
}

}  // namespace

std::string OwnerOf(Connection& database) {
  Statement row = database.Prepare("SELECT holder, since_ns FROM owners WHERE is_current");
  const absl::StatusOr<bool> found = row.Step();
  if (!found.ok() || !*found) return "another process";
  return absl::StrCat(row.Text(0), " (since ",
                      absl::FormatTime("%Y-%m-%d %H:%M:%S UTC", absl::FromUnixNanos(row.Int(1)),
                                       absl::UTCTimeZone()),
                      ")");
}

SiteLease::SiteLease(PostgresTarget target, const LeaseOptions& options)
    : PostgresConnection(std::move(target)), options_(options), me_(ThisProcess()) {}

absl::StatusOr<std::unique_ptr<SiteLease>> SiteLease::Take(PostgresTarget target,
                                                           const LeaseOptions& options) {
  target.application = absl::StrCat(target.schema, " owner");
  std::unique_ptr<SiteLease> lease(new SiteLease(std::move(target), options));
  if (absl::Status status = lease->AwaitSite(); !status.ok()) return status;
  lease->renewing_ = std::thread([owner = lease.get()] { owner->RenewLoop(); });
  if (options.on_wait) {
    lease->watching_ = std::thread([owner = lease.get()] { owner->WatchLoop(); });
  }
  return lease;
}

SiteLease::~SiteLease() {
  {
    MutexLock lock(&mutex_);
    is_ending_ = true;
    changed_.SignalAll();
  }
  if (renewing_.joinable()) renewing_.join();
  if (watching_.joinable()) watching_.join();
}

absl::Status SiteLease::Greet() {
  is_locked_ = false;
  // The trouble that cut this connection may have cut the owner's: it comes back sooner than this.
  if (std::exchange(was_connected_, true)) way_is_clear_ = Clock::now() + kGiveWay;
  return epoch_ == 0 ? CheckServer(*this, options_.on_problem)
                     : Execute("SET synchronous_commit TO off");
}

absl::Status SiteLease::AwaitSite() {
  const Clock::time_point until = Clock::now() + kWaitForLock;
  while (true) {
    const absl::StatusOr<bool> taken = TryTake();
    if (taken.ok() && *taken) return absl::OkStatus();
    const absl::Status why = taken.ok() ? Refused() : taken.status();
    if (!taken.ok() && !(options_.on_wait && absl::IsUnavailable(why))) return why;
    if (!options_.on_wait && Clock::now() >= until) return why;
    if (options_.on_wait && !options_.on_wait(std::string(why.message()))) {
      return absl::CancelledError("the site is waited for no more");
    }
    Rest(std::max<Clock::duration>(PauseLeft(), kLook));
  }
}

absl::StatusOr<bool> SiteLease::TryTake() {
  if (absl::Status status = EnsureConnected(); !status.ok()) return status;
  if (Clock::now() < way_is_clear_) return false;
  absl::StatusOr<bool> taken = TryLock();
  Seen from;
  if (taken.ok() && !*taken) {
    if (!options_.on_wait) return false;
    const absl::StatusOr<Seen> owner = Look();
    if (!owner.ok()) return owner.status();
    if (!owner->is_overdue) return false;
    from = *owner;
    taken = EndOwner(from);
  }
  if (!taken.ok() || !*taken) return taken;
  const absl::Status migrated = MigratePostgres(*this, target().schema);
  if (!migrated.ok()) return migrated;
  const absl::StatusOr<bool> mine = TakeEpoch(from.epoch);
  if (!mine.ok() || *mine) return mine;
  // Another one that waited was sooner, and may have been ended with the owner: it comes back.
  way_is_clear_ = Clock::now() + kGiveWay;
  return is_locked_ ? Unlock() : mine;
}

absl::StatusOr<bool> SiteLease::TryLock() {
  if (is_locked_) return true;
  Statement row = Prepare("SELECT pg_try_advisory_lock((?::bigint << 32) | ?)");
  const absl::StatusOr<bool> found = row.Bind(kOurs).Bind(LockOf(target().schema)).Step();
  if (!found.ok()) return found.status();
  is_locked_ = row.Int(0) != 0;
  return is_locked_;
}

absl::StatusOr<bool> SiteLease::Unlock() {
  is_locked_ = false;
  const absl::Status status = Prepare("SELECT pg_advisory_unlock((?::bigint << 32) | ?)")
                                  .Bind(kOurs)
                                  .Bind(LockOf(target().schema))
                                  .Step()
                                  .status();
  if (!status.ok()) return status;
  return false;
}

absl::StatusOr<SiteLease::Seen> SiteLease::Look() {
  // Only an owner that has begun with these tables has a lease to be overdue, not an older
  // program's.
  const auto has_lease = ReadNumber("SELECT (to_regclass('lease') IS NOT NULL)::int::bigint");
  if (!has_lease.ok()) return has_lease.status();
  if (*has_lease == 0) return Seen();
  // A clock that was set back would make a lease that never ends.
  Statement row = Prepare(
      "SELECT o.epoch, abs(extract(epoch FROM clock_timestamp() - l.renewed)) * 1000 > l.length_ms "
      "FROM owners o JOIN lease l ON l.epoch = o.epoch WHERE o.is_current");
  const absl::StatusOr<bool> found = row.Step();
  if (!found.ok()) return found.status();
  if (!*found) return Seen();
  return Seen{row.Int(0), row.Int(1) != 0};
}

absl::StatusOr<bool> SiteLease::EndOwner(const Seen& owner) {
  if (options_.on_problem) {
    options_.on_problem(absl::StrCat("the schema ", target().schema, ": ", OwnerOf(*this),
                                     " has not renewed its lease in time and loses it"));
  }
  // Not being allowed to costs time only: PostgreSQL ends its open transactions, once they have
  // been idle for its lease. Where another one that waited took the site since it was looked at,
  // these connections are that one's: without its lock a third would have the site.
  const absl::Status ended =
      Prepare(
          "SELECT count(pg_terminate_backend(pid)) FROM (SELECT pid FROM pg_locks WHERE "
          "locktype = 'advisory' AND granted AND classid = ?::bigint::oid AND objid = "
          "?::bigint::oid AND "
          "database = (SELECT oid FROM pg_database WHERE datname = current_database()) UNION "
          "SELECT pid FROM pg_stat_activity WHERE application_name = ? AND datname = "
          "current_database()) AS its WHERE EXISTS (SELECT FROM owners WHERE is_current AND "
          "epoch = ?)")
          .Bind(kOurs)
          .Bind(LockOf(target().schema))
          .Bind(absl::StrCat(target().schema, " writer"))
          .Bind(owner.epoch)
          .Step()
          .status();
  if (IsLost()) return ended;
  const Clock::time_point until = Clock::now() + kWaitForLock;
  while (Clock::now() < until) {
    absl::StatusOr<bool> locked = TryLock();
    if (!locked.ok() || *locked) return locked;
    const absl::StatusOr<Seen> now = Look();
    if (!now.ok()) return now.status();
    // Another one that waited was sooner, or it is back.
    if (now->epoch != owner.epoch || !now->is_overdue) return false;
    Rest(kFirstPause);
  }
  return true;  // A process that still has the lock is fenced by the epoch.
}

absl::StatusOr<bool> SiteLease::TakeEpoch(int64_t from) {
  Transaction transaction(*this);
  if (!transaction.status().ok()) return transaction.status();
  // Waits for a transaction of the one before, if there is one still.
  const absl::StatusOr<int64_t> before =
      Prepare("UPDATE owners SET is_current = FALSE WHERE is_current AND ? IN (0, epoch)")
          .Bind(from)
          .Change();
  if (!before.ok()) return before.status();
  if (from != 0 && *before == 0) return false;
  Statement insert = Prepare(
      "INSERT INTO owners (holder, since_ns, last_commit, is_current) VALUES (?, ?, 0, TRUE) "
      "RETURNING epoch");
  insert.Bind(me_).Bind(absl::GetCurrentTimeNanos());
  if (const absl::Status status = insert.Step().status(); !status.ok()) return status;
  const int64_t epoch = insert.Int(0);
  absl::Status status =
      Prepare("DELETE FROM owners WHERE epoch <= ?").Bind(epoch - kOwnersKept).Run();
  if (status.ok()) {
    {
      MutexLock lock(&mutex_);
      renewed_ = Clock::now();
    }
    status = Prepare(
                 "INSERT INTO lease (id, epoch, renewed, length_ms) VALUES (1, ?, "
                 "clock_timestamp(), ?) ON CONFLICT (id) DO UPDATE SET epoch = excluded.epoch, "
                 "renewed = excluded.renewed, length_ms = excluded.length_ms")
                 .Bind(epoch)
                 .Bind(int64_t{options_.length.count()})
                 .Run();
  }
  if (status.ok()) status = transaction.Commit();
  // A renewal need not outlast PostgreSQL's own death.
  if (status.ok()) status = Execute("SET synchronous_commit TO off");
  if (!status.ok()) return status;
  epoch_ = epoch;
  return true;
}

absl::Status SiteLease::Refused() {
  const std::string who =
      absl::StrCat("the schema ", target().schema, " is open in another server, ", OwnerOf(*this));
  if (options_.on_wait) return absl::FailedPreconditionError(who);
  return absl::FailedPreconditionError(
      absl::StrCat(who,
                   ": one server at a time has a site. Stop that one, or start this one with "
                   "--standby (storage.standby: true), which waits for the site"));
}

absl::StatusOr<bool> SiteLease::Renew() {
  const absl::StatusOr<int64_t> mine =
      Prepare("UPDATE lease SET renewed = clock_timestamp() WHERE epoch = ?").Bind(epoch_).Change();
  if (!mine.ok()) return mine.status();
  // Gone with a connection, or kept by an owner before that could not be ended: it comes.
  if (*mine == 1 && !is_locked_) TryLock().IgnoreError();
  return *mine == 1;
}

void SiteLease::RenewLoop() {
  NameThread("lease");
  Clock::duration pause(0);
  while (Rest(pause)) {
    const Clock::time_point now = Clock::now();
    absl::StatusOr<bool> mine;
    try {
      mine = Renew();
    } catch (...) {
      mine = CaughtStatus();
    }
    pause = std::max<Clock::duration>(PauseLeft(), kFirstPause);
    if (!mine.ok()) {
      MutexLock lock(&mutex_);
      trouble_ = std::string(mine.status().message());
      continue;
    }
    if (!*mine) {
      return Lose(absl::StrCat("the schema ", target().schema,
                               " was taken over by another server, ", OwnerOf(*this)));
    }
    pause = std::min(options_.length / kRenewals, kRenewEvery);
    MutexLock lock(&mutex_);
    renewed_ = now;
    trouble_.clear();
  }
}

void SiteLease::WatchLoop() {
  NameThread("lease_watch");
  Clock::duration left = options_.length;
  std::string trouble;
  while (Rest(left)) {
    MutexLock lock(&mutex_);
    left = renewed_ + options_.length - Clock::now();
    trouble = trouble_;
    if (left <= Clock::duration(0)) break;
  }
  if (trouble.empty()) trouble = "no answer came, or this process or its machine stood still";
  Lose(absl::StrCat("the schema ", target().schema, " could not be held for its lease of ",
                    options_.length.count(),
                    " ms, and another server may have taken it: ", trouble));
}

void SiteLease::Lose(const std::string& why) {
  {
    MutexLock lock(&mutex_);
    if (is_ending_ || std::exchange(is_lost_, true)) return;
    changed_.SignalAll();
  }
  if (options_.on_lost) options_.on_lost(why);
}

bool SiteLease::Rest(Clock::duration longest) {
  const Clock::time_point until = Clock::now() + longest;
  MutexLock lock(&mutex_);
  while (!is_ending_ && !is_lost_ && Clock::now() < until) {
    changed_.WaitFor(&mutex_, until - Clock::now());
  }
  return !is_ending_ && !is_lost_;
}

}  // namespace isthmus::storage
