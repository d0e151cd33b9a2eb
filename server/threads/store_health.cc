#include "server/threads/store_health.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include <utility>

#include "core/caught.h"
#include "core/concurrency/mutex.h"
#include "server/threads/limits.h"
#include "storage/forwarding_store.h"
#include "storage/objects/limits.h"

namespace isthmus::server {
namespace {

// True if it is the store that failed, not the batch.
bool IsStoreFailure(const absl::Status& status) {
  return absl::IsResourceExhausted(status) || absl::IsUnavailable(status) ||
         absl::IsDataLoss(status) || absl::IsInternal(status) || absl::IsUnknown(status);
}

class WatchedStore : public storage::ForwardingStore {
 public:
  WatchedStore(std::unique_ptr<storage::MapStore> store, StoreHealth* health)
      : ForwardingStore(std::move(store)), health_(health) {}

  absl::Status Write(const storage::WriteBatch& batch) override {
    return Noted([&] { return ForwardingStore::Write(batch); }, !batch.submaps.empty());
  }
  using ForwardingStore::DeleteSession;
  absl::Status DeleteSession(const SessionId& session, const std::vector<Event>& events) override {
    return Noted([&] { return ForwardingStore::DeleteSession(session, events); });
  }
  absl::Status PutFeatures(const storage::FeatureBlob& blob) override {
    return Noted([&] { return ForwardingStore::PutFeatures(blob); },
                 blob.data.size() >= storage::kSmallestObject);
  }

 private:
  // An exception is a failure of the store, too.
  template <typename Writing>
  absl::Status Noted(const Writing& write, bool is_large = false) {
    absl::Status status;
    try {
      status = write();
    } catch (...) {
      status = CaughtStatus();
    }
    health_->NoteWrite(status, is_large);
    return status;
  }

  StoreHealth* const health_;
};

}  // namespace

void StoreHealth::NoteWrite(const absl::Status& status, bool is_large) {
  const bool is_failure = IsStoreFailure(status);
  if (!status.ok() && !is_failure) return;
  MutexLock one_at_a_time(&telling_);
  std::string news;
  {
    MutexLock lock(&mutex_);
    const bool was_failing = !problem_.empty();
    const int64_t now_ns = clock_->NowNs();
    if (is_large) large_failed_ns_ = is_failure ? now_ns : INT64_MIN;
    const bool do_large_fail = large_failed_ns_ != INT64_MIN &&
                               now_ns - large_failed_ns_ < absl::ToInt64Nanoseconds(kLargeTried);
    if (!is_failure && do_large_fail) return;
    if (is_failure) {
      problem_ = absl::StrCat("the server cannot store: ", status.message());
      if (!was_failing) {
        since_ns_ = now_ns;
        news = problem_;
      }
    } else if (was_failing) {
      const double seconds = 1e-9 * static_cast<double>(now_ns - since_ns_);
      news = absl::StrCat("the server stores again, after ", seconds, " s in which it could not");
      problem_.clear();
    }
    changed_.SignalAll();
  }
  if (!news.empty() && on_change_) on_change_(is_failure, news);
}

std::string StoreHealth::Problem() const {
  MutexLock lock(&mutex_);
  if (problem_.empty()) return {};
  const std::string since = absl::FormatTime("%H:%M:%S UTC on %Y-%m-%d",
                                             absl::FromUnixNanos(since_ns_), absl::UTCTimeZone());
  return absl::StrCat(problem_, " (since ", since,
                      "). What it has is served. Robots send again what is not stored yet");
}

bool StoreHealth::WaitForProblem() {
  MutexLock lock(&mutex_);
  while (!is_stopped_ && problem_.empty()) changed_.Wait(&mutex_);
  return !is_stopped_;
}

bool StoreHealth::WaitFor(double seconds) {
  MutexLock lock(&mutex_);
  const absl::Time until = absl::Now() + absl::Seconds(seconds);
  while (!is_stopped_) {
    if (changed_.WaitWithDeadline(&mutex_, until)) break;
  }
  return !is_stopped_;
}

void StoreHealth::Stop() {
  MutexLock lock(&mutex_);
  is_stopped_ = true;
  changed_.SignalAll();
}

std::unique_ptr<storage::MapStore> WatchStore(std::unique_ptr<storage::MapStore> store,
                                              StoreHealth* health) {
  return std::make_unique<WatchedStore>(std::move(store), health);
}

}  // namespace isthmus::server
