// The log of changes from one composed map to the next, for clients that watch the map.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/concurrency/listeners.h"
#include "core/concurrency/mutex.h"
#include "core/map/composed_map.h"
#include "core/records/map_changes.h"
#include "server/map/map_writer.h"
#include "server/map_feed.h"

namespace isthmus::server {

// Keeps no points, and no map but the newest: of each step only the tiles, submaps and matches that
// it changed, so that any reader is told its news from the newest map alone. Of more than so many
// the oldest steps go, and a reader that knows of no later one begins anew. Until somebody asks for
// the first time, it does nothing. Thread safe.
class MapWatch : public MapFeed {
 public:
  static constexpr size_t kMaxLogged = size_t{1} << 18;  // As many as a map has tiles; 6 MB.

  explicit MapWatch(size_t max_logged = kMaxLogged);

  // A new map, and the view that it was composed of; from one thread. Wakes all that wait.
  void Note(const MapView& composed_of, std::shared_ptr<const ComposedMap> map);

  std::optional<MapStep> Since(const MapMark& known, uint32_t level) override;
  uint64_t OnChange(std::function<void()> wake) override { return wakes_.Add(std::move(wake)); }
  void Forget(uint64_t handle) override { wakes_.Remove(handle); }

 private:
  using SessionPair = std::pair<SessionId, SessionId>;
  // One map, as far as steps need it. Immutable.
  struct State {
    std::shared_ptr<const MapView> view;  // The map's view, but without its own older map.
    std::shared_ptr<const ComposedMap> map;
    std::vector<TileInfo> tiles;   // Tiles of level 0, in order.
    std::vector<uint32_t> levels;  // By component.
  };
  using StatePtr = std::shared_ptr<const State>;
  // The step to a revision.
  struct Change {
    int64_t revision = 0;
    std::vector<uint32_t> levels_before;  // By component.
    std::vector<TileId> tiles;
    std::vector<SubmapId> submaps;
    std::vector<SessionPair> matches;

    size_t size() const { return tiles.size() + submaps.size() + matches.size(); }
  };

  static StatePtr Describe(std::shared_ptr<const MapView> view,
                           std::shared_ptr<const ComposedMap> map);
  static Change Compare(const State& before, const State& now);
  static MapStep Everything(const State& state, uint32_t level);
  static MapStep Changed(const State& state, const Change& all, uint32_t level);
  static void AddTiles(const State& state, const Change& all, uint32_t level, MapStep* step);

  void Activate() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Log(Change change) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const size_t max_logged_;
  uint64_t run_ ABSL_GUARDED_BY(mutex_);
  Mutex mutex_;
  bool is_active_ ABSL_GUARDED_BY(mutex_) = false;
  std::shared_ptr<const MapView> view_ ABSL_GUARDED_BY(mutex_);  // Until it is active.
  std::shared_ptr<const ComposedMap> map_ ABSL_GUARDED_BY(mutex_);
  StatePtr state_ ABSL_GUARDED_BY(mutex_);              // From then on; may be null.
  std::deque<Change> changes_ ABSL_GUARDED_BY(mutex_);  // Oldest first.
  size_t logged_ ABSL_GUARDED_BY(mutex_) = 0;           // In them.
  int64_t known_from_ ABSL_GUARDED_BY(mutex_) = 0;      // No earlier revision is known.
  Listeners wakes_;
};

}  // namespace isthmus::server
