// The thread that keeps every submap placed: whenever something changes it works out where all lie
// and makes that a revision. Neither the robots nor readers wait for it.
#pragma once

#include <absl/status/statusor.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "core/concurrency/mutex.h"
#include "core/map/revision.h"
#include "server/map/map_writer.h"
#include "server/placement/placer.h"
#include "storage/map_store.h"

namespace isthmus::server {

class PlacementThread {
 public:
  // Told, from the thread, why what is new could not be placed.
  using OnProblem = std::function<void(const std::string& problem)>;

  // If placing throws, the last revision stands until the next change; then everything is placed,
  // by a placer without a memory of half-done work. Without a store, which is null, no revisions
  // are made: the map is placed as another server says, and only the edges that agree with that are
  // worked out here.
  PlacementThread(MapWriter* map, Activity* activity, storage::MapStore* store, const Clock* clock,
                  const placement::PlacerOptions& options, OnProblem on_problem = nullptr);
  ~PlacementThread();  // Stop(), and waits.

  // Ends once everything so far is placed; does not wait.
  void Stop();

  // Placer::WriteG2o. Waits for the optimisation under way.
  absl::StatusOr<std::string> WriteG2o(const MapName& map);

 private:
  void Run();
  // Places what the map says and shows it, or why it cannot.
  void PlaceMap();
  PlacedMap Solve(const MapWriter::ToPlace& task);
  // A revision of new placements, which differ from the previous ones by `moves`; stored if that is
  // possible. Readers see the newest truth even when it is not: it follows from what is stored and
  // is found again at the next start.
  std::shared_ptr<const MapRevision> MakeRevision(const MapRevision& previous,
                                                  const Changes& changes,
                                                  std::vector<SubmapMove> moves,
                                                  std::vector<Placement> placements);

  MapWriter* const map_;
  Activity* const activity_;
  storage::MapStore* const store_;  // May be null.
  const Clock* const clock_;
  const placement::PlacerOptions options_;
  const OnProblem on_problem_;
  Mutex placer_mutex_;
  placement::Placer placer_ ABSL_GUARDED_BY(placer_mutex_);
  // The revision that the store has when the latest could not be written. Touched by the thread
  // only.
  std::shared_ptr<const MapRevision> stored_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace isthmus::server
