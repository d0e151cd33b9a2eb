// Connections for reading, lent one at a time.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/concurrency/mutex.h"
#include "storage/sql/connection.h"

namespace isthmus::storage {

// Thread safe. Must outlive its leases.
class ConnectionPool {
 public:
  // Gives the connection back when it goes.
  class Lease {
   public:
    Lease(ConnectionPool& pool, std::unique_ptr<Connection> connection)
        : pool_(pool), connection_(std::move(connection)) {}
    ~Lease() { pool_.Return(std::move(connection_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    Connection& operator*() const { return *connection_; }

   private:
    ConnectionPool& pool_;
    std::unique_ptr<Connection> connection_;
  };

  explicit ConnectionPool(std::vector<std::unique_ptr<Connection>> connections)
      : free_(std::move(connections)) {}

  // Waits while all are lent.
  Lease Borrow() {
    MutexLock lock(&mutex_);
    while (free_.empty()) returned_.Wait(&mutex_);
    std::unique_ptr<Connection> connection = std::move(free_.back());
    free_.pop_back();
    return Lease(*this, std::move(connection));
  }

 private:
  void Return(std::unique_ptr<Connection> connection) {
    MutexLock lock(&mutex_);
    free_.push_back(std::move(connection));
    returned_.Signal();
  }

  Mutex mutex_;
  CondVar returned_;
  std::vector<std::unique_ptr<Connection>> free_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::storage
