// Writes of many threads share transactions, and with them the wait for the disk.
#pragma once

#include <absl/status/status.h>

#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "core/concurrency/mutex.h"
#include "storage/sql/connection.h"

namespace isthmus::storage {

// Thread safe. It has no thread of its own: a caller that finds nobody writing writes for all that
// came meanwhile, then hands on. Works are done in the order in which they came.
class GroupCommit {
 public:
  // May run several times, so must not change anything but the database.
  using Work = std::function<absl::Status(Connection&)>;

  // The connection is the only one that writes.
  explicit GroupCommit(std::unique_ptr<Connection> writer) : writer_(std::move(writer)) {}
  GroupCommit(const GroupCommit&) = delete;
  GroupCommit& operator=(const GroupCommit&) = delete;

  // Once this returns OK, all that `work` did is committed. Otherwise, by its own error or by one
  // of the database's, nothing of it has happened; works beside it are not touched by its errors. A
  // transaction that the database takes back for the sake of others (Aborted) is tried again by
  // itself.
  absl::Status Run(const Work& work);

 private:
  struct Request {
    explicit Request(const Work& asked) : work(asked) {}
    const Work& work;
    absl::Status status;
    bool is_done = false;
  };
  using Group = std::vector<Request*>;

  // The next waiting request that fits into a group of `size`, taken out of waiting_.
  Request* Next(size_t size);
  // The caller of the next ones leads. One transaction for all that come until it is committed;
  // false if it was lost, and all of `group` with it.
  bool CommitTogether(Group& group);
  void CommitAlone(Request& request);
  absl::Status TryAlone(const Work& work);

  const std::unique_ptr<Connection> writer_;  // The leader alone uses the connection.
  Mutex mutex_;
  CondVar changed_;
  std::deque<Request*> waiting_ ABSL_GUARDED_BY(mutex_);
  bool is_led_ ABSL_GUARDED_BY(mutex_) = false;  // Somebody is writing.
};

}  // namespace isthmus::storage
