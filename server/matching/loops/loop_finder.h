// Places that a session came back to, and steps in which its odometry errs: its newest submaps laid
// on its own older ones, and verified as matches between sessions are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "core/map/loop_closure.h"
#include "core/map/submap.h"
#include "server/matching/loops/loop_options.h"
#include "server/matching/prepared/prepared_map.h"

namespace isthmus::matching {

// A session as it is placed at present, loop closures found so far included.
struct LoopQuery {
  SessionId session;
  std::vector<std::shared_ptr<const Submap>> submaps;  // In order of index; gaps are retired ones.
  std::vector<Pose> T_map_submap;                      // Pose of each.
  size_t first_new = 0;                                // The first that was not asked before.
  std::vector<LoopClosure> known;                      // Found so far, rejected ones included.
};

// The state that later searches depend on, beside their query. Value type.
struct LoopMemory {
  struct Failure {  // A search in vain, in metres along the way.
    double old_path_length = 0, new_path_length = 0;
  };

  std::vector<Failure> failures;
  // Radii of the spheres around the surfaces of submaps that were prepared, by index.
  std::map<uint32_t, double> radii_m;
};

// Finds the loops of one session. Keeps prepared submaps and places, so that what a new submap
// costs does not grow with the session. Not thread safe; starts no threads.
class LoopFinder {
 public:
  // With `points` the submaps of queries may be outlines.
  explicit LoopFinder(const LoopOptions& options = {}, SubmapSource source = PrepareSubmap,
                      SubmapReader points = nullptr);
  ~LoopFinder();

  // At most a few closures for every new submap, without ids; none where nothing was found or
  // nothing is certain enough. Deterministic.
  std::vector<LoopClosure> Find(const LoopQuery& query);

  const LoopMemory& memory() const;
  // Takes the memory of another finder of the session, to find what that one would find next.
  void SetMemory(LoopMemory memory);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isthmus::matching
