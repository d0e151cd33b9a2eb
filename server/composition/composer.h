// Composition: the placed submaps thinned into one map, tile by tile. Runs often, with whatever
// transforms are at hand; recomputes only tiles whose submaps came, went or moved.
//
// Maps may be larger than memory: what the limit has no room for, thinned submaps and tiles alike,
// goes to a file. A submap is read and thinned once: what was saved is found by the next composer.
#pragma once

#include <absl/status/statusor.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/map/composed_map.h"

namespace isthmus::composition {

class MapFile;

// Values out of range are brought to the nearest sensible one: voxels of at least 1 mm, tiles of at
// least one voxel, at least 8 of them.
struct ComposerOptions {
  // Edge of a square tile in x and y, rounded to whole voxels; unbounded in z.
  double tile_m = 20;
  // One point per voxel and robot: the mean of what fell into it, from whichever submap.
  double voxel_m = 0.1;
  // A submap of which no point would move by more than this since it was last composed stays where
  // it is, and its tiles with it. Beyond 0 the map depends on what was composed before: made anew
  // from the same poses it is another one.
  double min_move_m = 0;
  // So many tiles at most, all components together, and an eighth of them for one submap: those
  // with most points. A tile costs some 20 microseconds and 700 bytes however little lies on it,
  // and a few megabytes of points strewn over the plane would make millions. What was measured is
  // far from that: these are 105 km2 at 20 m, and a submap's are 13, a road of 10 km seen 650 m to
  // either side. What lies on others is left out of the map, see Composer::left_out.
  int max_tiles = 1 << 18;
  // Points of thinned submaps and tiles, those of all maps that are still read included, take this
  // much memory, about; what else there is goes to a file. The map does not depend on it.
  size_t cache_bytes = size_t{192} << 20;
  // Points leave the map that other looks went through, see visibility/. Submaps are then read
  // again where their views do not fit into memory.
  bool drop_gone = false;
  // The folder of that file, see MapFile. Empty: all stays in memory and nothing is saved.
  std::string folder = {};
  // The file leaves so much of the disk free.
  uint64_t reserve_bytes = uint64_t{256} << 20;
};

// Not thread safe; one thread composes.
class Composer {
 public:
  // Begins with what another of the same options and version of the program saved in the folder.
  explicit Composer(const ComposerOptions& options);
  // With a file made by the caller instead of one in the folder.
  Composer(const ComposerOptions& options, std::shared_ptr<MapFile> file);
  ~Composer();

  // Told about which share of the work is done; returns false to cancel it. Asked every few
  // milliseconds, also in the middle of a submap of millions of points, but not while the reader
  // reads one: what cannot be cancelled at once takes tenths of a second at most.
  using Progress = std::function<bool(double share)>;

  // The map with exactly these submaps at these poses (to min_move_m). The result does not depend
  // on what was composed before or on the order of `submaps`. Where its points lie on more tiles
  // than the limit, those on the emptiest are left out. Submaps are read and thinned when
  // first seen and known again by what is said of them. Submaps without points, a null pointer or a
  // pose that is not finite add nothing, nor do points that are not finite or more than a million
  // voxels from the origin of the map. One that the reader has not is left out, counted as missing
  // and asked for again the next time. `waiting` is what the map says of submaps that are not among
  // these yet. The map never changes and shares unchanged tiles with those
  // made before; it may outlive the composer.
  //
  // ResourceExhausted when the file's disk is full, Unavailable when it fails otherwise, DataLoss
  // when not even what was read anew could be read back, Cancelled by `progress`. Earlier maps are
  // then as valid as before, and the next call goes on where this one ended.
  absl::StatusOr<std::shared_ptr<const ComposedMap>> Compose(
      int64_t revision, const std::vector<PlacedSubmap>& submaps, const SubmapReader& reader,
      const Progress& progress = nullptr, uint64_t waiting = 0);
  // The submaps of these that would not be read again.
  std::set<SubmapId> Known(const std::vector<PlacedSubmap>& submaps) const;
  // The ContentOf submaps that came without, and were read since the last call.
  std::vector<std::pair<SubmapId, uint64_t>> TakeContents();
  // Keeps the last composed map for the next composer, through a power cut as well. Writes what
  // changed since the last time. Does nothing without a folder, or after a Compose that failed:
  // what was saved before stays. Fails as the file does, and as kept() says.
  absl::Status Save();
  // OK, or why maps are not kept for the next composer: a FailedPrecondition that says what to do.
  absl::Status kept() const;

  // True if the last map has points that could not be read back, or is not whole: the next Compose
  // makes these tiles again, of the same submaps too.
  bool has_lost() const;
  // Called when that becomes so, from a thread that reads, until the composer is destroyed.
  void TellLost(std::function<void()> on_lost);

  // The submap whose points the Compose under way is at, or was at when something was thrown;
  // nothing in between. After that the composer is of no more use.
  std::optional<SubmapId> at_hand() const;
  // Tiles that the last Compose remade.
  int last_tiles_remade() const;

  // The part of the last composed map that lies on tiles beyond the limit.
  struct LeftOut {
    uint64_t points = 0;  // Thinned ones.
    SubmapId most;        // The submap with most of them, the first of equals; if there are any.
  };
  LeftOut left_out() const;

  struct Memory {
    size_t submap_bytes = 0, tile_bytes = 0;  // Points in memory.
    uint64_t spilled_bytes = 0;               // In the file.
  };
  Memory memory() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isthmus::composition
