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

// The source that makes them.
std::shared_ptr<const PreparedSubmap> PrepareSubmap(const std::shared_ptr<const Submap>& submap);

// Does not change; safe to use from many threads. Holds on to the submaps.
class PreparedMap {
 public:
  // `shape` is what the session knows of how the submaps of `map` lie to each other; null: what
  // its odometry says, no loops.
  explicit PreparedMap(const SessionMap& map, const SubmapSource& source = PrepareSubmap,
                       std::shared_ptr<const SessionShape> shape = nullptr);

  // The map that `before` was the beginning of: prepared submaps are taken over, and as long as it
  // has not grown by a quarter the level, places and the free space too, so that what this takes
  // depends on the new submaps and their surroundings only. Where submaps were retired from it, the
  // free space is made anew, as others show what they showed. Where `before` is something else, all
  // is made anew.
  PreparedMap(const SessionMap& map, const PreparedMap& before,
              const SubmapSource& source = PrepareSubmap,
              std::shared_ptr<const SessionShape> shape = nullptr);

  const SessionMap& session_map() const { return map_; }
  const std::shared_ptr<const SessionShape>& shape() const { return shape_; }
  const PreparedSubmaps& submaps() const { return submaps_; }
  const FreeSpaceMap& free_space() const { return free_space_; }
  // Of every submap with the one before: how well surfaces of this robot agree in this world where
  // they certainly lie right. Measured when first asked for, of what is new since `before`.
  SurfaceAgreement own_agreement() const;
  // Places along the way, in order; `first_place(k)` is where those of submap k begin.
  const std::vector<Place>& places() const { return places_; }
  size_t first_place(size_t submap) const {
    return submap < first_places_.size() ? first_places_[submap] : places_.size();
  }
  // Pure rotation: the level frame has odom's origin, z up, as far as can be told (LikeliestUp).
  const Pose& T_level_odom() const { return T_level_odom_; }
  // Of the two ends of the vertical the other is nearly as likely to be up.
  bool may_be_upside_down() const { return may_be_upside_down_; }
  // The memory it takes, about.
  size_t bytes() const;
  // The time it took to make so far, wall time.
  double prepare_ms() const;

  // The map as a whole: made when first asked for, kept. What it takes grows with the map.
  struct Whole {
    RefineOptions refine_options;  // Of the refinable map: coarser outdoors.
    RefinableMap refinable;
    WallMap walls;
  };
  const Whole& whole() const;
  // Its walls with the other end up. Made when first asked for, kept, as is how it repeats.
  const WallMap& turned_over() const;
  const SelfSimilarity& self_similarity() const;
  // By the repeats of the map as it was, until it has grown to twice that.
  const DistinctiveMap& distinctive() const;
  // Made when first asked for, grown from those of `before`.
  const Things& things() const;

 private:
  // Those of `before` at these positions, and new ones.
  void TakeSubmaps(const PreparedMap* before, const std::vector<size_t>& kept,
                   const SubmapSource& source);
  void TakePlaces(const PreparedMap& before, const std::vector<size_t>& kept);
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
  size_t levelled_ = 0;  // Submaps when level and free space were last made from scratch.
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
