#include "fleet/postgresql/worker_store.h"

#include <absl/strings/str_cat.h>

#include <utility>
#include <vector>

#include "fleet/postgresql/job_tables.h"
#include "fleet/postgresql/limits.h"
#include "fleet/postgresql/migrations.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/site_bucket.h"
#include "fleet/postgresql/unowned_store.h"

namespace isthmus::storage {
namespace {

PostgresTarget TargetOf(const std::string& url, const std::string& site) {
  PostgresTarget target{url, SchemaOfSite(site), "", /*sync_every_commit=*/false};
  target.application = absl::StrCat(target.schema, " worker");
  return target;
}

// All that a job needs, so that nobody waits for a worker that could not end it.
absl::Status CheckRights(Connection& database, const std::string& schema) {
  if (absl::Status status = CheckUsage(database, schema); !status.ok()) return status;
  const absl::StatusOr<bool> has_tables = HasJobTables(database);
  if (!has_tables.ok()) return has_tables.status();
  if (!*has_tables) {
    return absl::NotFoundError(
        "the site has no tables for this program's jobs: start the server that has the map, of "
        "this version, which makes them");
  }
  Statement row = database.Prepare(
      "SELECT coalesce(string_agg(privilege || ' on ' || name, ', '), '') FROM (VALUES "
      "('about', 'SELECT'), ('sessions', 'SELECT'), ('submaps', 'SELECT'), "
      "('submap_blobs', 'SELECT'), ('features', 'SELECT'), ('features', 'INSERT'), "
      "('features', 'UPDATE'), ('jobs', 'SELECT'), ('jobs', 'UPDATE'), ('workers', 'SELECT'), "
      "('workers', 'INSERT'), ('workers', 'UPDATE'), ('workers', 'DELETE'), "
      "('bucket', 'SELECT')) AS needed (name, "
      "privilege) WHERE NOT has_table_privilege(to_regclass(name), privilege)");
  if (absl::Status status = row.Step().status(); !status.ok()) return status;
  if (row.Text(0).empty()) return absl::OkStatus();
  return absl::PermissionDeniedError(
      absl::StrCat("its role in the database needs ", row.Text(0),
                   "; docs/postgresql.md has what to GRANT to a worker's role"));
}

// True for a change of one row.
absl::StatusOr<bool> IsOne(const absl::StatusOr<int64_t>& changed) {
  if (!changed.ok()) return changed.status();
  return *changed == 1;
}

}  // namespace

absl::StatusOr<std::unique_ptr<MapStore>> OpenWorkerStore(const std::string& url,
                                                          const std::string& site) {
  if (absl::Status status = CheckSite(site); !status.ok()) return status;
  const PostgresTarget target = TargetOf(url, site);
  auto writer = PostgresConnection::Open(target);
  if (!writer.ok()) return writer.status();
  absl::Status status = CheckRights(**writer, target.schema);
  if (status.ok()) status = CheckMigrated(**writer, target.schema);
  if (!status.ok()) return status;
  std::vector<std::unique_ptr<Connection>> readers;
  auto reader = PostgresConnection::Open(target);
  if (!reader.ok()) return reader.status();
  readers.push_back(*std::move(reader));
  auto large_values = OpenSiteBucket(**writer);
  if (large_values.ok() && *large_values != nullptr) status = (*large_values)->Check();
  if (!large_values.ok()) return large_values.status();
  if (!status.ok()) return status;
  return std::make_unique<UnownedStore>(*std::move(writer), std::move(readers),
                                        *std::move(large_values), OpenSiteBucket);
}

JobTaker::JobTaker(std::unique_ptr<PostgresConnection> connection, std::string schema,
                   std::string worker)
    : connection_(std::move(connection)), schema_(std::move(schema)), worker_(std::move(worker)) {}

JobTaker::~JobTaker() {
  MutexLock lock(&mutex_);
  connection_->Prepare("DELETE FROM workers WHERE name = ?")
      .Bind(worker_)
      .Change()
      .status()
      .IgnoreError();
}

absl::StatusOr<std::unique_ptr<JobTaker>> JobTaker::Open(const std::string& url,
                                                         const std::string& site,
                                                         const std::string& worker) {
  auto connection = PostgresConnection::Open(TargetOf(url, site));
  if (!connection.ok()) return connection.status();
  std::unique_ptr<JobTaker> taker(new JobTaker(*std::move(connection), SchemaOfSite(site), worker));
  if (auto alive = taker->KeepAlive(std::nullopt); !alive.ok()) return alive.status();
  return taker;
}

absl::StatusOr<std::optional<TakenJob>> JobTaker::Take() {
  MutexLock lock(&mutex_);
  // No worker counts beyond the limit: somebody did by hand, and the next one could not count on.
  absl::Status status =
      connection_
          ->Prepare(
              "UPDATE jobs SET state = 'set aside', problem = ? WHERE state = 'taken' AND "
              "attempt >= ? AND lease_until < clock_timestamp() OR state IN ('waiting', 'taken') "
              "AND attempt NOT BETWEEN 0 AND ?")
          .Bind(SetAsideReason())
          .Bind(kMaxAttempts)
          .Bind(kMaxAttempts)
          .Change()
          .status();
  if (!status.ok()) return status;
  // A worker that finds the first one locked, as another takes it just now, takes the next.
  Statement row = connection_->Prepare(
      "UPDATE jobs SET state = 'taken', attempt = attempt + 1, worker = ?, lease_until = "
      "clock_timestamp() + ? * interval '1 ms' WHERE id = (SELECT id FROM jobs WHERE version = ? "
      "AND (state = 'waiting' OR state = 'taken' AND lease_until < clock_timestamp()) "
      "ORDER BY is_urgent DESC, id LIMIT 1 FOR UPDATE SKIP LOCKED) RETURNING id, attempt, key, "
      "payload");
  const absl::StatusOr<bool> found =
      row.Bind(worker_).Bind(int64_t{kJobLease.count()}).Bind(JobVersion()).Step();
  if (!found.ok()) return found.status();
  if (!*found) return std::nullopt;
  return TakenJob{row.Int(0), row.Int(1), row.Text(2), row.Text(3), connection_->generation()};
}

absl::StatusOr<bool> JobTaker::KeepAlive(const std::optional<TakenJob>& job) {
  MutexLock lock(&mutex_);
  absl::Status status = CheckRights(*connection_, schema_);
  if (!status.ok()) return status;
  status = connection_
               ->Prepare(
                   "INSERT INTO workers (name, seen, version) VALUES (?, clock_timestamp(), ?) "
                   "ON CONFLICT (name) DO UPDATE SET seen = excluded.seen, version = "
                   "excluded.version")
               .Bind(worker_)
               .Bind(JobVersion())
               .Change()
               .status();
  if (!status.ok() || !job) return status.ok() ? absl::StatusOr<bool>(true) : status;
  Statement renew = OfMine("lease_until = clock_timestamp() + ? * interval '1 ms'");
  return IsOne(renew.Bind(int64_t{kJobLease.count()}).Bind(job->id).Bind(job->attempt).Change());
}

Statement JobTaker::OfMine(const std::string& change) {
  return connection_->Prepare(absl::StrCat("UPDATE jobs SET ", change,
                                           " WHERE id = ? AND attempt = ? AND state = 'taken'"));
}

absl::StatusOr<bool> JobTaker::Finish(const TakenJob& job, const std::string& result) {
  MutexLock lock(&mutex_);
  Statement end = OfMine("state = 'done', result = ?");
  return IsOne(end.BindBlob(result).Bind(job.id).Bind(job.attempt).Change());
}

absl::StatusOr<bool> JobTaker::Fail(const TakenJob& job, const std::string& problem) {
  MutexLock lock(&mutex_);
  Statement end = OfMine("state = 'failed', problem = ?");
  return IsOne(end.Bind(problem).Bind(job.id).Bind(job.attempt).Change());
}

absl::StatusOr<bool> JobTaker::GiveBack(const TakenJob& job) {
  MutexLock lock(&mutex_);
  Statement end = OfMine("state = 'waiting', attempt = attempt - 1");
  return IsOne(end.Bind(job.id).Bind(job.attempt).Change());
}

}  // namespace isthmus::storage
