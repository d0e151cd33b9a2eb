// The one connection that writes a site's tables, while it is the site's owner.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "fleet/postgresql/postgresql.h"

namespace isthmus::storage {

// Every transaction checks that the epoch of its SiteLease is still the newest: that keeps out one
// that was taken for dead once another has the site.
class SiteWriter : public PostgresConnection {
 public:
  using OnProblem = std::function<void(const std::string& problem)>;
  // The epoch is of a lease that is held.
  static absl::StatusOr<std::unique_ptr<SiteWriter>> Open(const PostgresTarget& target,
                                                          int64_t epoch, OnProblem on_problem);

 private:
  SiteWriter(PostgresTarget target, int64_t epoch, OnProblem on_problem);
  absl::Status Greet() override;
  absl::Status BeginWrite() override;
  // If the way is lost meanwhile, waits until PostgreSQL can tell whether it was committed.
  absl::Status Commit() override;

  // After the way was lost: ends the rest of the old connection, finds out its last commit, and
  // whether the site is still this one's.
  absl::Status Return();
  absl::Status FindOut(int64_t commit);
  absl::Status TakenOver();  // Names the owner of the site.

  const int64_t epoch_;
  const OnProblem on_problem_;
  int64_t backend_ = 0;        // The process of PostgreSQL that serves us; 0: none yet,
  std::string backend_start_;  // and since when: numbers come again.
  int64_t commit_ = 0;         // The last one begun.
  int64_t acknowledged_ = 0;   // The last one of which Commit said OK.
  int64_t known_commit_ = 0;   // The last one by the table.
  bool is_asked_ = false;      // known_commit_ was read since the way was lost.
};

}  // namespace isthmus::storage
