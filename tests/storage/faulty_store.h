// A store that fails when a test wants it to.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <random>
#include <set>

#include "storage/map_store.h"

namespace isthmus::storage {

// What goes wrong with the store that shares it. Nothing, at first. Thread safe.
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
  // Writes wait until Resume. Those that wait when the test ends wait for ever.
  void Stall();
  void Resume();

  // Writes that were asked for, stalled ones too; those that were made fail.
  int64_t writes() const;
  int64_t failed_writes() const;

  // For the store: what to give instead of going on, or OK.
  absl::Status BeforeWrite();
  absl::Status BeforeRead() const;
  absl::Status BeforeReading(const SubmapId& submap) const;
  bool IsDamaged(const SessionId& session) const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable resumed_;
  // All guarded by mutex_.
  std::mt19937 random_;
  bool is_full_ = false;
  bool is_stalled_ = false;
  int fail_count_ = 0;
  absl::Status fail_status_;
  absl::Status read_status_;
  double failure_rate_ = 0;
  std::chrono::microseconds slowest_{0};
  std::set<SubmapId> damaged_;
  std::set<SessionId> damaged_checkpoints_;
  int64_t writes_ = 0;
  int64_t failed_writes_ = 0;
};

// All of MapStore's promises, but for what `faults` spoil.
std::unique_ptr<MapStore> MakeFaultyStore(std::unique_ptr<MapStore> store,
                                          std::shared_ptr<Faults> faults);

}  // namespace isthmus::storage
