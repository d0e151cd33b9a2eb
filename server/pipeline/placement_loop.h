// Keeps every submap placed: whenever something changed, works out where all lie and makes that a
// revision, on a thread of its own. Neither the robots nor readers wait for it.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "core/revision.h"
#include "server/pipeline/map_state.h"
#include "server/placement/placer.h"
#include "storage/map_store.h"

namespace isthmus::server {

class PlacementLoop {
 public:
  PlacementLoop(MapState* state, storage::MapStore* store, const Clock* clock,
                const placement::PlacerOptions& options);
  ~PlacementLoop();  // Stop(), and waits.

  // Ends once everything so far is placed; does not wait.
  void Stop();

  // Placer::WriteG2o. Waits for the optimisation under way.
  absl::StatusOr<std::string> WriteG2o(uint32_t component);

 private:
  void Run();
  // Places what the state says and publishes it. `lock` is on the state's mutex, and is released
  // in between.
  void Place(std::unique_lock<std::mutex>* lock);

  MapState* const state_;
  storage::MapStore* const store_;
  const Clock* const clock_;
  std::mutex placer_mutex_;  // Locked after the state's mutex was released.
  placement::Placer placer_;
  // What the store has of the latest revision, when that could not be written. Touched by the
  // thread only.
  std::optional<std::vector<Placement>> stored_;
  bool stop_ = false;  // Guarded by the state's mutex.
  std::thread thread_;
};

}  // namespace isthmus::server
