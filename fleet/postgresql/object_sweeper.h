// A thread that deletes the objects of a site to which nothing refers any more.
#pragma once

#include <absl/time/time.h>

#include <functional>
#include <string>
#include <thread>

#include "core/concurrency/mutex.h"
#include "fleet/postgresql/site_bucket.h"
#include "storage/objects/large_values.h"

namespace isthmus::storage {

// Only the site's owner has one. Waits, when it goes, for a sweep that is under way.
class ObjectSweeper {
 public:
  // All must outlive it. Problems are told from its thread, the same one once.
  ObjectSweeper(LargeValues& values, RunOnConnection read, RunOnConnection write,
                std::function<void(const std::string& problem)> on_problem);
  ~ObjectSweeper();
  ObjectSweeper(const ObjectSweeper&) = delete;
  ObjectSweeper& operator=(const ObjectSweeper&) = delete;

 private:
  void Loop();
  bool Rest(absl::Duration duration);  // False when it is to end.

  LargeValues& values_;
  const RunOnConnection read_, write_;
  const std::function<void(const std::string& problem)> on_problem_;
  Mutex mutex_;
  CondVar changed_;
  bool is_ending_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace isthmus::storage
