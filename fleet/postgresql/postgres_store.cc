#include "fleet/postgresql/postgres_store.h"

#include <absl/strings/str_cat.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>
#include <utility>

#include "core/site_name.h"
#include "fleet/postgresql/job_tables.h"
#include "fleet/postgresql/limits.h"
#include "fleet/postgresql/object_sweeper.h"
#include "fleet/postgresql/site_bucket.h"
#include "fleet/postgresql/site_writer.h"
#include "storage/sql/sql_store.h"

namespace isthmus::storage {
namespace {

using Clock = std::chrono::steady_clock;

class PostgresStore : public SqlStore {
 public:
  PostgresStore(std::unique_ptr<SiteLease> lease, std::unique_ptr<Connection> writer,
                std::vector<std::unique_ptr<Connection>> readers, const PostgresOptions& options,
                std::unique_ptr<LargeValues> large_values)
      : SqlStore(std::move(writer), std::move(readers), options.resolution_m,
                 std::move(large_values)),
        lease_(std::move(lease)),
        jobs_(MakeJobQueue([this](const auto& work) { return Read(work); },
                           [this](const auto& work) { return WriteBy(work); })) {
    if (SqlStore::large_values() == nullptr) return;
    sweeper_ = std::make_unique<ObjectSweeper>(
        *SqlStore::large_values(), [this](const auto& work) { return Read(work); },
        [this](const auto& work) { return WriteBy(work); }, options.on_problem);
  }

  // If the role may not use the tables of jobs, there are none, and the server does all itself.
  absl::Status PrepareJobs(const std::function<void(const std::string&)>& on_problem) {
    const absl::Status status = WriteBy(PrepareJobTables);
    if (!absl::IsFailedPrecondition(status)) return status;
    jobs_ = nullptr;
    if (on_problem) on_problem(absl::StrCat("workers are not used: ", status.message()));
    return absl::OkStatus();
  }
  bool IsRemote() const override { return true; }
  JobQueue* jobs() override { return jobs_.get(); }

  absl::Status Write(const WriteBatch& batch) override {
    absl::Status status = SqlStore::Write(batch);
    if (status.ok()) LookAtSize();
    return status;
  }

  StoreSize SizeOnDisk() const override { return {size_, 0}; }

  // Asks the database how large its tables are, unless that was asked a moment ago.
  void LookAtSize() {
    const auto now = Clock::now().time_since_epoch();
    Clock::rep next = next_look_;
    if (now.count() < next) return;
    const Clock::rep later = (now + Clock::duration(kSizeIsGoodFor)).count();
    if (!next_look_.compare_exchange_strong(next, later)) return;
    const auto bytes = AtOneMoment<int64_t>([](Connection& reader) {
      return reader.ReadNumber(
          "SELECT coalesce(sum(pg_total_relation_size(c.oid)), 0)::bigint FROM pg_class c "
          "JOIN pg_namespace n ON n.oid = c.relnamespace "
          "WHERE n.nspname = current_schema() AND c.relkind = 'r'");
    });
    if (bytes.ok()) size_ = static_cast<uint64_t>(*bytes);
  }

 private:
  absl::Status Read(const std::function<absl::Status(Connection&)>& work) {
    return AtOneMoment<bool>([&](Connection& reader) -> absl::StatusOr<bool> {
             if (absl::Status status = work(reader); !status.ok()) return status;
             return true;
           })
        .status();
  }

  const std::unique_ptr<SiteLease> lease_;
  std::unique_ptr<JobQueue> jobs_;
  std::atomic<uint64_t> size_{0};
  std::atomic<Clock::rep> next_look_{0};
  std::unique_ptr<ObjectSweeper> sweeper_;  // Null without a bucket. Goes first.
};

}  // namespace

std::string SchemaOfSite(const std::string& site) {
  return site.empty() || site == kDefaultSite ? "isthmus" : absl::StrCat("isthmus_", site);
}

absl::Status CheckSite(const std::string& site) {
  absl::Status status = site.empty() ? absl::OkStatus() : CheckSiteName(site);
  if (!status.ok()) return status;
  constexpr size_t kLongestName = 63;  // PostgreSQL cuts longer ones off.
  if (SchemaOfSite(site).size() <= kLongestName) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "the site ", site, " has too long a name for PostgreSQL, which takes 55 characters"));
}

namespace {

absl::StatusOr<std::unique_ptr<MapStore>> OpenOnce(PostgresTarget target,
                                                   const PostgresOptions& options) {
  LeaseOptions lease_options = options.lease;
  lease_options.on_problem = options.on_problem;
  auto lease = SiteLease::Take(target, lease_options);
  if (!lease.ok()) return lease.status();
  target.application = absl::StrCat(target.schema, " writer");
  target.idle_limit = options.lease.length;
  auto writer = SiteWriter::Open(target, (*lease)->epoch(), options.on_problem);
  if (!writer.ok()) return writer.status();
  target.application = absl::StrCat(target.schema, " reader");
  target.idle_limit = {};
  std::vector<std::unique_ptr<Connection>> readers;
  for (int i = 0; i < kPostgresReaders; ++i) {
    auto reader = PostgresConnection::Open(target);
    if (!reader.ok()) return reader.status();
    readers.push_back(*std::move(reader));
  }
  auto large_values =
      OpenOwnersBucket(**writer, options.bucket, target.schema, options.smallest_object);
  if (!large_values.ok()) return large_values.status();
  auto store = std::make_unique<PostgresStore>(
      *std::move(lease), *std::move(writer), std::move(readers), options, *std::move(large_values));
  if (absl::Status status = store->PrepareJobs(options.on_problem); !status.ok()) return status;
  store->LookAtSize();
  return store;
}

}  // namespace

absl::StatusOr<std::unique_ptr<MapStore>> OpenPostgresStore(const std::string& url,
                                                            const std::string& site,
                                                            const PostgresOptions& options) {
  if (auto status = CheckResolution(options.resolution_m); !status.ok()) return status;
  if (absl::Status status = CheckSite(site); !status.ok()) return status;
  const PostgresTarget target{url, SchemaOfSite(site), "", options.sync_every_commit};
  while (true) {
    auto store = OpenOnce(target, options);
    // A server that waits for the site waits also once it got it, if PostgreSQL is away again.
    const auto& on_wait = options.lease.on_wait;
    if (store.ok() || !on_wait || !absl::IsUnavailable(store.status())) return store;
    if (!on_wait(std::string(store.status().message()))) {
      return absl::CancelledError("the site is waited for no more");
    }
    std::this_thread::sleep_for(kGiveWay);
  }
}

}  // namespace isthmus::storage
