// The state of the store: whether what comes in can be stored at the moment, and if not, why and
// since when.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/clock.h"
#include "core/concurrency/mutex.h"
#include "storage/map_store.h"

namespace isthmus::server {

// Thread safe.
class StoreHealth {
 public:
  // `on_change`, if any, is told, also in words, when storing begins to fail and when it works
  // again; from any thread, one call at a time.
  using OnChange = std::function<void(bool fails, const std::string& news)>;
  StoreHealth(const Clock* clock, OnChange on_change)
      : clock_(clock), on_change_(std::move(on_change)) {}

  // Notes the outcome of a write. An error of the batch itself says nothing about the store. Where
  // what is large could not be written, as its bucket is away, it says nothing either that
  // something small could, unless nothing large failed for kLargeTried.
  void NoteWrite(const absl::Status& status, bool is_large = false);

  // For people, a sentence; empty while all is well.
  std::string Problem() const;
  // Waits while all is well. False once it was stopped.
  bool WaitForProblem();
  // Waits that long; false once it was stopped.
  bool WaitFor(double seconds);
  void Stop();

 private:
  const Clock* const clock_;
  const OnChange on_change_;
  Mutex telling_;  // Serialises NoteWrite, so that on_change_ is told in order.
  mutable Mutex mutex_ ABSL_ACQUIRED_AFTER(telling_);
  CondVar changed_;
  std::string problem_ ABSL_GUARDED_BY(mutex_);
  int64_t since_ns_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t large_failed_ns_ ABSL_GUARDED_BY(mutex_) = INT64_MIN;  // The last time; since then none.
  bool is_stopped_ ABSL_GUARDED_BY(mutex_) = false;
};

// All of `store`'s promises; notes how its writes end. `health` must outlive it.
std::unique_ptr<storage::MapStore> WatchStore(std::unique_ptr<storage::MapStore> store,
                                              StoreHealth* health);

}  // namespace isthmus::server
