#include "server/matching/prepared/prepared_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/stopwatch.h"
#include "server/matching/prepared/limits.h"
#include "server/matching/registration/limits.h"
#include "server/matching/search/gravity.h"
#include "server/matching/search/limits.h"
#include "server/matching/search/up_candidates.h"

namespace isthmus::matching {
namespace {

// One plane alone may be a floor or a wall: it takes both to tell which way is up.
bool HasFloorsAndWalls(const std::vector<SurfacePoint>& surface, const Eigen::Quaterniond& R) {
  const Eigen::Vector3f up = (R.inverse() * Eigen::Vector3d::UnitZ()).cast<float>();
  size_t level = 0, upright = 0;
  for (const SurfacePoint& point : surface) {
    const float along = std::abs(point.normal.dot(up));
    level += along > 0.9f;
    upright += along < 0.3f;
  }
  return static_cast<double>(std::min(level, upright)) >
         kMinSurfaceShare * static_cast<double>(surface.size());
}

// By floors, walls and ceilings; near odom's z where they do not tell.
Pose Level(const SessionMap& map, const PreparedSubmaps& submaps, bool* doubtful) {
  double voxel_m = kOutdoorVoxelM;
  const std::vector<SurfacePoint> surface = JoinSurfaces(submaps, kMaxLevelSurfaces, &voxel_m);
  const UpCandidate up = LikeliestUp(FindUpCandidates(surface, SensorPositions(map)));
  const bool leans = up.R_level_odom.angularDistance(Eigen::Quaterniond::Identity()) < kMaxLeanRad;
  const bool stands = (up.R_level_odom * Eigen::Vector3d::UnitZ()).z() > kUprightCosine;
  *doubtful = up.opposite > (stands ? kDoubtfulStanding : kDoubtfulUp) * up.score;
  const bool tells = leans || HasFloorsAndWalls(surface, up.R_level_odom);
  return Pose(tells ? up.R_level_odom : EstimateLevel(surface), Eigen::Vector3d::Zero());
}

// Outdoors cars and hedges fill what is near the ground.
PlaceDescriptorOptions PlaceOptions(const PreparedSubmap& submap) {
  PlaceDescriptorOptions options;
  if (submap.voxel_m() < kOutdoorVoxelM) return options;
  options.low_m = 0.2f;
  options.high_m = 7.0f;
  return options;
}

}  // namespace

std::optional<std::vector<size_t>> FindSameSubmaps(const SessionMap& before,
                                                   const SessionMap& map) {
  if (before.session != map.session) return std::nullopt;
  std::vector<size_t> kept;
  size_t at = 0;
  for (const auto& submap : map.submaps) {
    while (at < before.submaps.size() && before.submaps[at]->id.index < submap->id.index) ++at;
    if (at == before.submaps.size()) break;
    const Submap& known = *before.submaps[at];
    if (known.id != submap->id || known.first_stamp_ns != submap->first_stamp_ns) {
      return std::nullopt;
    }
    kept.push_back(at++);
  }
  if (kept.empty() && !before.submaps.empty()) return std::nullopt;
  return kept;
}

std::optional<std::vector<size_t>> FindKept(const SessionMap& before, const SessionMap& map) {
  const auto same = FindSameSubmaps(before, map);
  for (size_t k = 0; same && k < same->size(); ++k) {
    const Pose& lay = before.submaps[(*same)[k]]->T_odom_submap;
    if (lay.Matrix() != map.submaps[k]->T_odom_submap.Matrix()) return std::nullopt;
  }
  return same;
}

std::shared_ptr<const PreparedSubmap> PrepareSubmap(const std::shared_ptr<const Submap>& submap) {
  return std::make_shared<const PreparedSubmap>(submap);
}

size_t LevelledAt(size_t submaps) {
  size_t levelled = std::min<size_t>(submaps, 1);
  while (true) {
    const auto next = static_cast<size_t>(std::ceil(kNewMapGrowth * static_cast<double>(levelled)));
    if (levelled == 0 || next > submaps) return levelled;
    levelled = next;
  }
}

PreparedMap::PreparedMap(const SessionMap& map, const SubmapSource& source,
                         std::shared_ptr<const SessionShape> shape)
    : PreparedMap(map, nullptr, source, std::move(shape)) {}

PreparedMap::PreparedMap(const SessionMap& map, const PreparedMap& before,
                         const SubmapSource& source, std::shared_ptr<const SessionShape> shape)
    : PreparedMap(map, &before, source, std::move(shape)) {}

PreparedMap::PreparedMap(const SessionMap& map, const PreparedMap* before,
                         const SubmapSource& source, std::shared_ptr<const SessionShape> shape)
    : map_(map), shape_(std::move(shape)), levelled_(LevelledAt(map.submaps.size())) {
  const Stopwatch watch;
  const std::optional<std::vector<size_t>> kept =
      before != nullptr ? FindKept(before->map_, map) : std::nullopt;
  for (const size_t i : kept.value_or(std::vector<size_t>())) {
    submaps_.push_back(before->submaps_[i]);
  }
  for (size_t i = submaps_.size(); i < map_.submaps.size(); ++i) {
    submaps_.push_back(source(map_.submaps[i]));
  }
  const bool is_grown =
      kept && kept->size() == before->submaps_.size() && levelled_ == before->levelled_;
  if (is_grown) {
    T_level_odom_ = before->T_level_odom_;
    may_be_upside_down_ = before->may_be_upside_down_;
    free_space_ = before->free_space_;
    places_ = before->places_;
    first_places_ = before->first_places_;
    MutexLock lock(&before->mutex_);
    own_agreement_ = before->own_agreement_;
    own_measured_ = before->own_measured_;
    distinctive_ = before->distinctive_;
    things_ = before->things_;
  } else {
    SessionMap first = map_;
    first.submaps.resize(levelled_);
    T_level_odom_ = Level(first, First(levelled_), &may_be_upside_down_);
    free_space_ = FreeSpaceMap(First(levelled_), T_level_odom_, FreeSpaceOptions());
  }
  for (size_t k = free_space_.pieces().size(); k < submaps_.size(); ++k) {
    free_space_ =
        FreeSpaceMap(std::move(free_space_), First(k + 1), T_level_odom_, FreeSpaceOptions());
  }
  DescribeNewPlaces();
  prepare_ms_ = watch.Ms();
}

PreparedSubmaps PreparedMap::First(size_t count) const {
  return {submaps_.begin(), submaps_.begin() + static_cast<std::ptrdiff_t>(count)};
}

SurfaceAgreement PreparedMap::own_agreement() const {
  MutexLock lock(&mutex_);
  const Eigen::Vector3d up = T_level_odom_.rotation().inverse() * Eigen::Vector3d::UnitZ();
  for (size_t& k = own_measured_; k < submaps_.size(); ++k) {
    const auto T_odom = [&](size_t i) { return submaps_[i]->submap().T_odom_submap; };
    own_agreement_ += MeasureAgreement(*submaps_[k], T_odom(k), {submaps_[k - 1]}, {T_odom(k - 1)},
                                       up, kOnSurfaceM);
  }
  return own_agreement_;
}

void PreparedMap::DescribeNewPlaces() {
  for (size_t i = first_places_.size(); i < submaps_.size(); ++i) {
    first_places_.push_back(places_.size());
    for (Place& place :
         DescribePlaces(*map_.Whole(i), T_level_odom_.rotation(), PlaceOptions(*submaps_[i]))) {
      places_.push_back(std::move(place));
    }
  }
}

size_t PreparedMap::bytes() const {
  size_t bytes = sizeof(PreparedMap) + places_.size() * sizeof(Place);
  for (const auto& submap : submaps_) {
    // The free space has most of the surface again, and so has the map as a whole, if it is made.
    bytes += submap->bytes() + 2 * submap->surface().size() * sizeof(SurfacePoint);
  }
  return bytes;
}

double PreparedMap::prepare_ms() const {
  MutexLock lock(&mutex_);
  return prepare_ms_;
}

PreparedMap::Whole PreparedMap::MakeWhole(const PreparedSubmaps& submaps) const {
  SessionMap map = map_;
  map.submaps.resize(submaps.size());
  RefineOptions options;
  const bool indoors = std::any_of(submaps.begin(), submaps.end(), [](const auto& submap) {
    return submap->voxel_m() < kOutdoorVoxelM;
  });
  options.voxel_m = indoors ? kIndoorVoxelM : kOutdoorVoxelM;
  std::vector<SurfacePoint> surface =
      JoinSurfaces(submaps, static_cast<size_t>(options.max_points), &options.voxel_m);
  WallMap walls(map, surface, T_level_odom_);
  if (indoors && walls.outdoors()) {
    options.voxel_m = std::max(options.voxel_m, kOutdoorVoxelM);
    surface = JoinSurfaces(submaps, static_cast<size_t>(options.max_points), &options.voxel_m);
    walls = WallMap(map, surface, T_level_odom_);
  }
  RefinableMap refinable(std::move(surface), options);
  return {options, std::move(refinable), std::move(walls)};
}

const PreparedMap::Whole& PreparedMap::whole() const {
  MutexLock lock(&mutex_);
  if (whole_) return *whole_;
  const Stopwatch watch;
  whole_.emplace(MakeWhole(submaps_));
  prepare_ms_ += watch.Ms();
  return *whole_;
}

const WallMap& PreparedMap::turned_over() const {
  const WallMap& upright = whole().walls;
  MutexLock lock(&mutex_);
  if (turned_over_) return *turned_over_;
  const Stopwatch watch;
  double voxel_m = whole_->refine_options.voxel_m;
  const std::vector<SurfacePoint> surface =
      JoinSurfaces(submaps_, static_cast<size_t>(whole_->refine_options.max_points), &voxel_m);
  const Eigen::Quaterniond over(0, 1, 0, 0);  // Half a turn about x.
  turned_over_.emplace(map_, surface, Pose(over, Eigen::Vector3d::Zero()) * upright.T_level_odom());
  prepare_ms_ += watch.Ms();
  return *turned_over_;
}

const SelfSimilarity& PreparedMap::self_similarity() const {
  const Whole& whole = this->whole();
  MutexLock lock(&mutex_);
  if (self_similarity_) return *self_similarity_;
  const Stopwatch watch;
  self_similarity_ = MeasureSelfSimilarity(whole.walls, whole.refinable, whole.refine_options);
  prepare_ms_ += watch.Ms();
  return *self_similarity_;
}

std::vector<Pose> PreparedMap::FirstMoves() const {
  if (levelled_ == submaps_.size()) return self_similarity().Moves(kMostMoves);
  const Whole first = MakeWhole(First(levelled_));
  return MeasureSelfSimilarity(first.walls, first.refinable, first.refine_options)
      .Moves(kMostMoves);
}

const DistinctiveMap& PreparedMap::distinctive() const {
  const Eigen::Vector3d up = T_level_odom_.rotation().inverse() * Eigen::Vector3d::UnitZ();
  bool is_known = false;
  {
    MutexLock lock(&mutex_);
    is_known = distinctive_.has_value();
  }
  const std::vector<Pose> moves = is_known ? std::vector<Pose>() : FirstMoves();
  MutexLock lock(&mutex_);
  if (!distinctive_) distinctive_.emplace(First(levelled_), up, moves);
  for (size_t k = distinctive_->submaps(); k < submaps_.size(); ++k) {
    distinctive_ = DistinctiveMap(*std::move(distinctive_), First(k + 1));
  }
  return *distinctive_;
}

const Things& PreparedMap::things() const {
  MutexLock lock(&mutex_);
  if (!things_) things_.emplace(map_, First(levelled_), T_level_odom_);
  for (size_t k = things_->submaps(); k < submaps_.size(); ++k) {
    things_ = Things(*std::move(things_), map_, First(k + 1), T_level_odom_);
  }
  return *things_;
}

}  // namespace isthmus::matching
