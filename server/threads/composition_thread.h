// The fast loop: a thread that composes the merged map anew, with the transforms at hand.
#pragma once

#include <absl/status/statusor.h>
#include <absl/time/time.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/stopwatch.h"
#include "server/composition/composer.h"
#include "server/map/map_writer.h"
#include "server/threads/composition_turns.h"
#include "server/threads/loading_map.h"

namespace isthmus::server {

class CompositionThread {
 public:
  // Told, from the thread, why the map is not as new as it should be, or what it leaves out; once
  // per reason.
  using OnProblem = std::function<void(const std::string& problem)>;
  // Told, from the thread, of each map that is shown, and the view that it was composed of.
  using OnComposed =
      std::function<void(const MapView& composed_of, const std::shared_ptr<const ComposedMap>&)>;

  // Composes after changes, and rests after each for kRestPerWork times what it took, the interval
  // at most (0: never). Where that fails, as on a full disk, the last map stays and it is tried
  // again every few seconds. A composition under way ends when a session is deleted, and goes on at
  // once without it; the next one is then made to its end, so that there are new maps however often
  // sessions are deleted. Until what the store holds been composed once, readers get a LoadingMap,
  // unless the options' folder has a map that was saved: what came since then comes to that. It is
  // saved every kSaveMapEvery, when sessions were removed, and at the end. After the first map new
  // submaps come in turns, see CompositionTurns: of a revision there may be a map without the large
  // ones, and then one with them.
  // Where `reader` throws StatusError, as the store is away, it is asked again until that is back:
  // no map is made of a part. A submap at which something else is thrown twice, by the reader or
  // what makes the map (no memory for it, for one), is left out until the next start; `activity` is
  // told which, and why. What it is given must hold out until the thread is destroyed.
  CompositionThread(MapWriter* map, Activity* activity, SubmapReader reader,
                    const composition::ComposerOptions& options, double interval_s,
                    OnProblem on_problem = nullptr, OnComposed on_composed = nullptr);
  ~CompositionThread();

  // Makes the thread end after one last composition of what is there, if that takes no more than a
  // moment: a composition under way ends, in the middle of a submap if need be, within a second and
  // what reading one submap takes. Nothing is lost by that: a map is made anew from the store.
  // Does not wait.
  void Stop();

  // The memory that the composer takes, as of its last composition.
  composition::Composer::Memory memory() const;

 private:
  void Run();
  // One composition, or a wait. False when the thread is to end.
  bool RunOnce();
  absl::StatusOr<std::shared_ptr<const ComposedMap>> Compose(int64_t revision,
                                                             const CompositionTurns::Turn& turn);
  // After something was thrown: what to try next.
  absl::Status Recover(const absl::Status& caught);
  // Waits for a store that is away; throws StatusError where the thread is to do something else.
  std::shared_ptr<const Submap> Read(const SubmapId& id);
  bool KeepsOn();
  // The composition under way may give way, and there is something new.
  bool GivesWay() const;
  // After a while, or where sessions were removed, whose points are not to be kept.
  void KeepContents();
  void SaveSometimes(uint64_t removals);
  void Save();
  void ReportNotKept(const absl::Status& why);
  void MakeComposer();
  void ReportLeftOut();
  void ReportProblem(const absl::Status& status);
  std::shared_ptr<const ComposedMap> FirstMap();
  void Show(const MapView& composed_of, std::shared_ptr<const ComposedMap> map);

  MapWriter* const map_;
  Activity* const activity_;
  const SubmapReader read_;
  const SubmapReader reader_;  // The same, but for those that failed too often, once it can.
  const composition::ComposerOptions options_;
  const double interval_s_;
  const OnProblem on_problem_;
  const OnComposed on_composed_;
  mutable Mutex memory_mutex_;
  composition::Composer::Memory memory_ ABSL_GUARDED_BY(memory_mutex_);
  // All that follows is touched by the thread only, but for stop_.
  std::unique_ptr<composition::Composer> composer_;  // Null: to be made anew.
  std::map<SubmapId, int> failures_;                 // Times that something was thrown at it.
  std::shared_ptr<LoadingMap> loading_;              // Null once there is a map.
  std::string problem_;                              // The last reported.
  std::optional<SubmapId> left_out_;                 // Submap with most points left out.
  std::atomic<bool> stop_ = false;
  std::optional<Stopwatch> since_stop_;  // Since the thread saw it.
  absl::Time next_allowed_ = absl::InfinitePast();
  absl::Time next_save_ = absl::InfinitePast();
  uint64_t saved_removals_ = 0;  // MapView::removals of the map saved last.
  std::string save_problem_;     // The last reported.
  bool cancelled_ = false;       // The last composition.
  // Sessions removed when the composition under way began; nothing if it goes on whatever is
  // removed.
  std::optional<uint64_t> removals_;
  CompositionTurns turns_;
  std::optional<int64_t> gives_way_;  // Revision of the one under way, if it may give way.
  std::thread thread_;
};

}  // namespace isthmus::server
