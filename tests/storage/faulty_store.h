// A store that fails when a test wants it to.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <random>
#include <set>

#include "core/concurrency/mutex.h"
#include "storage/map_store.h"

namespace isthmus::storage {

// The faults of the store that shares them. Nothing, at first. Thread safe.
class Faults {
 public:
  explicit Faults(uint32_t seed = 0) : random_(seed) {}

  // Writes give ResourceExhausted, reads go on.
  void SetDiskFull(bool is_full);
  // The next `count` writes give `status`, whatever else was asked for; none of them happens.
  void FailWrites(int count, const absl::Status& status);
  // Each write gives Unavailable with this probability, by the seed; it does not happen.
  void SetFailureRate(double probability);
  // As one whose blob is damaged: GetSubmap gives DataLoss.
  void Damage(const SubmapId& submap);
  // Its checkpoint, likewise, comes without data.
  void Damage(const SessionId& session);
  // All reads give `status`; OK ends it.
  void FailReads(const absl::Status& status);
  // Writes take up to that long more, by the seed.
  void SetSlowest(std::chrono::microseconds slowest);
  // Writes wait until Resume; if the test ends before, for ever.
  void Stall();
  void Resume();

  // Writes that were asked for, stalled ones too; writes that were made fail.
  int64_t writes() const;
  int64_t failed_writes() const;

  // For the store: the error to return instead of going on, or OK.
  absl::Status BeforeWrite();
  absl::Status BeforeRead() const;
  absl::Status BeforeReading(const SubmapId& submap) const;
  bool IsDamaged(const SessionId& session) const;

 private:
  mutable Mutex mutex_;
  CondVar resumed_;
  std::mt19937 random_ ABSL_GUARDED_BY(mutex_);
  bool is_full_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_stalled_ ABSL_GUARDED_BY(mutex_) = false;
  int fail_count_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status fail_status_ ABSL_GUARDED_BY(mutex_);
  absl::Status read_status_ ABSL_GUARDED_BY(mutex_);
  double failure_rate_ ABSL_GUARDED_BY(mutex_) = 0;
  std::chrono::microseconds slowest_ ABSL_GUARDED_BY(mutex_){0};
  std::set<SubmapId> damaged_ ABSL_GUARDED_BY(mutex_);
  std::set<SessionId> damaged_checkpoints_ ABSL_GUARDED_BY(mutex_);
  int64_t writes_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t failed_writes_ ABSL_GUARDED_BY(mutex_) = 0;
};

// All of MapStore's promises, but for what `faults` spoil.
std::unique_ptr<MapStore> MakeFaultyStore(std::unique_ptr<MapStore> store,
                                          std::shared_ptr<Faults> faults);

}  // namespace isthmus::storage
