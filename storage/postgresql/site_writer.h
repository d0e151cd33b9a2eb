// The one connection that writes a site's tables, while it is the site's owner.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <string>

#include "storage/postgresql/postgresql.h"

namespace isthmus::storage {

// Owner is who holds the site's lock, which goes with its connection, and whose epoch is the
// newest. The lock keeps a second server out; the epoch, which every transaction checks, keeps out
// one that was taken for dead, or lost its connection, once another has the site.
class SiteWriter : public PostgresConnection {
 public:
  using OnProblem = std::function<void(const std::string& problem)>;
  // Brings the tables to the newest schema. FailedPrecondition when another process has the site
  // (the message says which), the schema is newer than this program, it belongs to another one, or
  // the database is not in UTF-8.
  static absl::StatusOr<std::unique_ptr<SiteWriter>> Open(const PostgresTarget& target,
                                                          OnProblem on_problem);

 private:
  SiteWriter(PostgresTarget target, OnProblem on_problem);
  absl::Status Greet() override;
  absl::Status BeginWrite() override;
  // Where the way is lost meanwhile, waits until PostgreSQL can tell whether it was committed.
  absl::Status Commit() override;

  absl::Status TakeLock();
  absl::Status CheckServer();
  absl::Status TakeEpoch();
  // After the way was lost: ends what is left of the old connection, finds out what it committed
  // last, and whether the site is still this one's.
  absl::Status Return();
  absl::Status FindOut(int64_t commit);
  absl::Status Refused(const std::string& why);  // Names who has the site.
  std::string Holder();

  const OnProblem on_problem_;
  const std::string me_;       // Host and process.
  int64_t epoch_ = 0;          // 0: none yet.
  int64_t backend_ = 0;        // The process of PostgreSQL that has our lock,
  std::string backend_start_;  // and since when: numbers come again.
  int64_t commit_ = 0;         // The last one begun.
  int64_t acknowledged_ = 0;   // The last one of which Commit said OK.
  int64_t known_commit_ = 0;   // What the table said last.
  bool is_asked_ = false;      // known_commit_ was read since the way was lost.
};

}  // namespace isthmus::storage
