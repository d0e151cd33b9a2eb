// The bucket that has the large values of a site's tables.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/time/time.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "storage/objects/large_values.h"
#include "storage/objects/limits.h"
#include "storage/sql/connection.h"

namespace isthmus::storage {

// The bucket of the site whose tables these are; null if it has none. Errors as S3Bucket::Open.
absl::StatusOr<std::unique_ptr<LargeValues>> OpenSiteBucket(Connection& database);

// The same by the connection that may write, for the site's owner: a site that has none has the
// bucket at `url` from now on, unless this is empty. Values in the tables already stay there.
// `smallest` as LargeValues has it. FailedPrecondition where the site has another; else the errors
// of S3Bucket, of a first object too.
absl::StatusOr<std::unique_ptr<LargeValues>> OpenOwnersBucket(Connection& writer,
                                                              const std::string& url,
                                                              const std::string& schema,
                                                              size_t smallest = kSmallestObject);

struct SweptObjects {
  size_t objects = 0;       // All that there were.
  size_t unreferenced = 0;  // Part of `objects`.
  size_t deleted = 0;       // Part of `unreferenced`.
};

using RunOnConnection =
    std::function<absl::Status(const std::function<absl::Status(Connection&)>& work)>;

// Deletes objects to which no row has referred since a sweep that was `stay` ago: their values were
// replaced or deleted, or never committed. The tables note since when; times are PostgreSQL's.
absl::StatusOr<SweptObjects> SweepObjects(LargeValues& values, const RunOnConnection& read,
                                          const RunOnConnection& write, absl::Duration stay);

}  // namespace isthmus::storage
