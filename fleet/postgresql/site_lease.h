// The right to write a site's tables: its lock, its newest epoch, and the lease that is renewed
// while its owner lives.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "core/concurrency/mutex.h"
#include "fleet/postgresql/limits.h"
#include "fleet/postgresql/postgresql.h"

namespace isthmus::storage {

struct LeaseOptions {
  // An owner that has not renewed for so long may lose the site to one that waits. By PostgreSQL's
  // clock.
  std::chrono::milliseconds length = kLease;
  // Set: the site is waited for, not refused, and this is told at each look why; false gives up
  // (Cancelled). PostgreSQL may be away meanwhile. Others are taken to wait as well, so an owner
  // that cannot renew in time gives the site up.
  std::function<bool(const std::string& why)> on_wait = nullptr;
  // Told once at most, from a thread of the lease, that the site is this one's no more, or may be
  // another's. Writes from then on may be refused.
  std::function<void(const std::string& why)> on_lost = nullptr;
  // Told what a person should know.
  std::function<void(const std::string& problem)> on_problem = nullptr;
};

// The owner of the site, for people, by any connection to its schema.
std::string OwnerOf(Connection& database);

// The owner has the newest epoch: every transaction of a SiteWriter checks that, so one that was
// taken for dead writes nothing, whatever it believes. The lock goes with this connection, and so
// tells at once of an owner that died; the lease tells of one that hangs, is paused or cut off. Its
// threads renew the lease, and watch that this succeeds in time.
class SiteLease : private PostgresConnection {
 public:
  // Brings the tables to the newest schema. FailedPrecondition when another process has the site
  // (the message says which), the schema is newer than this program, it belongs to another one, or
  // the database is not in UTF-8. The application of the target is the schema's name and "owner".
  static absl::StatusOr<std::unique_ptr<SiteLease>> Take(PostgresTarget target,
                                                         const LeaseOptions& options);
  // Gives it up. Waits for work under way.
  ~SiteLease() override;

  int64_t epoch() const { return epoch_; }

 private:
  using Clock = std::chrono::steady_clock;
  // The present owner.
  struct Seen {
    int64_t epoch = 0;
    bool is_overdue = false;
  };

  SiteLease(PostgresTarget target, const LeaseOptions& options);
  absl::Status Greet() override;

  absl::Status AwaitSite();
  // One look: true if the site is this one's now.
  absl::StatusOr<bool> TryTake();
  absl::StatusOr<bool> TryLock();
  absl::StatusOr<bool> Unlock();  // False, or an error.
  absl::StatusOr<Seen> Look();
  // Ends the connections of an owner that is overdue, where that is allowed. True when the site may
  // be taken from it.
  absl::StatusOr<bool> EndOwner(const Seen& owner);
  // False if the owner is not `from` any more; 0: any owner.
  absl::StatusOr<bool> TakeEpoch(int64_t from);
  absl::Status Refused();

  void RenewLoop();
  absl::StatusOr<bool> Renew();
  void WatchLoop();
  void Lose(const std::string& why);
  // False when it is to end.
  bool Rest(Clock::duration longest);

  const LeaseOptions options_;
  const std::string me_;  // Host and process.
  int64_t epoch_ = 0;     // 0: none yet. Constant once the threads run.
  bool is_locked_ = false;
  bool was_connected_ = false;
  Clock::time_point way_is_clear_ = {};  // Until then the site is left to its owner.

  Mutex mutex_;
  CondVar changed_;
  bool is_ending_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_lost_ ABSL_GUARDED_BY(mutex_) = false;
  // The time at which the last renewal that succeeded was sent.
  Clock::time_point renewed_ ABSL_GUARDED_BY(mutex_);
  std::string trouble_ ABSL_GUARDED_BY(mutex_);  // Why renewals since then failed; empty: none has.
  std::thread renewing_, watching_;
};

}  // namespace isthmus::storage
