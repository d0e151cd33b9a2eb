// The tables by which a site's server and its workers speak to each other.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <string>

#include "storage/job_queue.h"
#include "storage/sql/connection.h"

namespace isthmus::storage {

// Makes the tables that are missing, and clears away jobs that other versions of the program have
// posted. They hold nothing that cannot be lost, so they belong to no version of the map's schema,
// and isthmus copy leaves them out.
absl::Status PrepareJobTables(Connection& database);
// They are as this program makes them.
absl::StatusOr<bool> HasJobTables(Connection& database);

// The program's version: workers of another version leave jobs alone, as they would do them
// otherwise.
std::string JobVersion();

// The text about a job that worker after worker has ended with.
std::string SetAsideReason();

// Runs something on a connection, in a transaction.
using RunOn = std::function<absl::Status(const std::function<absl::Status(Connection&)>& work)>;

// `write` is the site owner's, so that a server that lost the site posts nothing.
std::unique_ptr<JobQueue> MakeJobQueue(RunOn read, RunOn write);

}  // namespace isthmus::storage
