// A session's submaps as the search for loops uses them: prepared maps of one submap each, of which
// the few in use are kept in memory, and a few facts about all of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "core/lru_cache.h"
#include "core/map/submap.h"
#include "server/matching/prepared/prepared_map.h"
#include "server/matching/search/place_search.h"

namespace isthmus::matching {

// Not thread safe.
class LoopSubmaps {
 public:
  // With `points` the submaps given may be outlines. `radii_m`, by index, is of those that were
  // asked for by Prepared or Places; it outlives the object.
  LoopSubmaps(SubmapSource source, size_t capacity, SubmapReader points,
              std::map<uint32_t, double>* radii_m);

  // The submap alone, level, with its free space and places.
  std::shared_ptr<const PreparedMap> Prepared(const std::shared_ptr<const Submap>& submap);
  // From prepared submaps that are kept, as far as they are.
  PreparedMap Window(const std::vector<std::shared_ptr<const Submap>>& submaps);
  // In the submap's frame: T_odom_place is T_submap_place. Prepares the submap if it never was.
  const std::vector<Place>& Places(const std::shared_ptr<const Submap>& submap);
  // The radius of the surface's sphere; `otherwise` while the submap was never asked for.
  double Radius(uint32_t index, double otherwise) const;

  // Forgets everything about submaps that are not among these, in order of index.
  void KeepOnly(const std::vector<std::shared_ptr<const Submap>>& submaps);

 private:
  struct Facts {
    double radius_m = 0;
    std::vector<Place> places;
  };

  SessionMap MapOf(const std::vector<std::shared_ptr<const Submap>>& submaps) const;

  const SubmapSource source_;
  const SubmapReader points_;
  const size_t capacity_;
  std::map<uint32_t, double>* const radii_m_;
  LruCache<uint32_t, std::shared_ptr<const PreparedMap>> used_;
  std::map<uint32_t, Facts> facts_;
};

// As its submaps say, all of them.
bool IsOutdoors(const PreparedMap& map);

// The position of the sensor in the middle of the submap, in its frame.
Eigen::Vector3d MiddleOf(const Submap& submap);

// The way travelled to the middle of each, from the first submap's beginning. Retired submaps in
// between count as long as the one before them.
std::vector<double> PathLengths(const std::vector<std::shared_ptr<const Submap>>& submaps);

}  // namespace isthmus::matching
