// A session's map with everything the matcher needs of it, made once and used against many others.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/map/submap.h"
#include "server/matching/prepared/distinctive.h"
#include "server/matching/prepared/free_space.h"
#include "server/matching/prepared/prepared_submap.h"
#include "server/matching/prepared/self_similarity.h"
#include "server/matching/prepared/session_shape.h"
#include "server/matching/prepared/surface_agreement.h"
#include "server/matching/prepared/things.h"
#include "server/matching/registration/refine.h"
#include "server/matching/search/place_search.h"
#include "server/matching/search/wall_map.h"

namespace isthmus::matching {

// The beginning of a map from which submaps were retired: the positions in `before` of those that
// are left, which `map`, of the same session, begins with in this order before newer ones come.
// Nothing where it does not, or where none are left of some.
std::optional<std::vector<size_t>> FindKept(const SessionMap& before, const SessionMap& map);

// The same for submaps that may lie elsewhere than they did: they are told by their indices.
std::optional<std::vector<size_t>> FindSameSubmaps(const SessionMap& before, const SessionMap& map);

// The source of prepared submaps: made, or kept from before. Never null.
using SubmapSource = std::function<std::shared_ptr<const PreparedSubmap>(
    const std::shared_ptr<const Submap>& submap)>;

// The number of submaps that a map of so many is made of at first: it grows by a quarter at a time.
size_t LevelledAt(size_t submaps);

// The source that makes them.
std::shared_ptr<const PreparedSubmap> PrepareSubmap(const std::shared_ptr<const Submap>& submap);

// Does not change; safe to use from many threads. Holds on to the submaps.
//
// Level, free space, places, things and repeats are made of the first submaps, as many as
// LevelledAt says, and grown by the others one by one: a map that has grown is the same, bit for
// bit, as one that is made at once, and what a new submap takes does not grow with the map.
class PreparedMap {
 public:
  // `shape` is what the session knows of how the submaps of `map` lie to each other; null: what
  // its odometry says, no loops.
  explicit PreparedMap(const SessionMap& map, const SubmapSource& source = PrepareSubmap,
                       std::shared_ptr<const SessionShape> shape = nullptr);

  // The same map, only sooner made where `before` was the beginning of it.
  PreparedMap(const SessionMap& map, const PreparedMap& before,
              const SubmapSource& source = PrepareSubmap,
              std::shared_ptr<const SessionShape> shape = nullptr);

  const SessionMap& session_map() const { return map_; }
  const std::shared_ptr<const SessionShape>& shape() const { return shape_; }
  const PreparedSubmaps& submaps() const { return submaps_; }
  const FreeSpaceMap& free_space() const { return free_space_; }
  // The agreement of every submap with the one before: this robot's surfaces in this world where
  // they certainly lie right. Measured when first asked for, for submaps new since `before`.
  SurfaceAgreement own_agreement() const;
  // Places along the way, in order; `first_place(k)` is where those of submap k begin.
  const std::vector<Place>& places() const { return places_; }
  size_t first_place(size_t submap) const {
    return submap < first_places_.size() ? first_places_[submap] : places_.size();
  }
  // Pure rotation: the level frame has odom's origin, z up, as far as can be told (LikeliestUp).
  const Pose& T_level_odom() const { return T_level_odom_; }
  // The other end of the vertical is nearly as likely to be up.
  bool may_be_upside_down() const { return may_be_upside_down_; }
  // The memory it takes, about.
  size_t bytes() const;
  // The time it took to make so far, wall time.
  double prepare_ms() const;

  // The map as a whole: made when first asked for, kept. What it takes grows with the map.
  struct Whole {
    RefineOptions refine_options;  // For the refinable map: coarser outdoors.
    RefinableMap refinable;
    WallMap walls;
  };
  const Whole& whole() const;
  // Its walls with the other end up. Made when first asked for, kept, as is how it repeats.
  const WallMap& turned_over() const;
  const SelfSimilarity& self_similarity() const;
  const DistinctiveMap& distinctive() const;
  const Things& things() const;

 private:
  // The map takes over what `before`, null for none, has to give.
  PreparedMap(const SessionMap& map, const PreparedMap* before, const SubmapSource& source,
              std::shared_ptr<const SessionShape> shape);
  // The first `count` submaps.
  PreparedSubmaps First(size_t count) const;
  Whole MakeWhole(const PreparedSubmaps& submaps) const;
  // The moves that lay the submaps that it is made of at first on themselves.
  std::vector<Pose> FirstMoves() const;
  // Describes the places of submaps that have none yet.
  void DescribeNewPlaces();

  SessionMap map_;
  std::shared_ptr<const SessionShape> shape_;
  PreparedSubmaps submaps_;
  Pose T_level_odom_;
  bool may_be_upside_down_ = false;
  FreeSpaceMap free_space_;
  std::vector<Place> places_;
  std::vector<size_t> first_places_;  // By submap.
  size_t levelled_ = 0;               // LevelledAt.
  mutable Mutex mutex_;
  mutable SurfaceAgreement own_agreement_ ABSL_GUARDED_BY(mutex_);
  mutable size_t own_measured_ ABSL_GUARDED_BY(mutex_) = 1;  // The first has none before it.
  // These stay as they are once they are there.
  mutable std::optional<Whole> whole_ ABSL_GUARDED_BY(mutex_);
  mutable std::optional<WallMap> turned_over_ ABSL_GUARDED_BY(mutex_);
  mutable std::optional<SelfSimilarity> self_similarity_ ABSL_GUARDED_BY(mutex_);
  mutable std::optional<DistinctiveMap> distinctive_ ABSL_GUARDED_BY(mutex_);
  mutable std::optional<Things> things_ ABSL_GUARDED_BY(mutex_);
  mutable double prepare_ms_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace isthmus::matching
