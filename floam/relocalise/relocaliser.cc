#include "floam/relocalise/relocaliser.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/geometry/near.h"
#include "floam/relocalise/limits.h"

namespace isthmus::floam {
namespace {

Eigen::Quaterniond TiltOf(const Pose& pose) {
  return Eigen::AngleAxisd(-pose.Yaw(), Eigen::Vector3d::UnitZ()) * pose.rotation();
}

}  // namespace

Relocaliser::Relocaliser(const MatchOptions& matching, const RelocaliserOptions& options,
                         const Eigen::Quaterniond& R_base_sensor)
    : options_(options),
      T_level_odom_(R_base_sensor, Eigen::Vector3d::Zero()),
      own_(std::make_shared<MapMemory>(options.memory)),
      memory_(own_),
      check_(matching, options.check) {
  Reset();
}

void Relocaliser::UseMemory(std::shared_ptr<const MapMemory> memory) {
  memory_ = std::move(memory);
  check_.Clear();
}

void Relocaliser::Remember(const Submap& submap) {
  own_->Add(submap, T_level_odom_ * submap.T_odom_submap);
  check_.Clear();
}

Cloud Relocaliser::PointsAround(const Eigen::Vector3d& position, double radius_m) const {
  std::vector<MapMemory::SeenPoint> points;
  MapMemory::ForTilesAround(
      (T_level_odom_ * position).head<2>(), radius_m,
      [&](MapMemory::TileIndex index) { memory_->AppendPoints(index, &points); });
  Cloud cloud;
  const Pose T_odom_level = T_level_odom_.Inverse();
  for (const MapMemory::SeenPoint& seen : points) {
    const Eigen::Vector3f p = (T_odom_level * seen.position.cast<double>()).cast<float>();
    cloud.push_back({p.x(), p.y(), p.z(), 0});
  }
  return cloud;
}

void Relocaliser::Reset() {
  lost_ = 0;
  next_search_ = spacing_ = options_.patience;
  regions_.clear();
  candidates_.clear();
  check_.Clear();
}

std::optional<MatchResult> Relocaliser::Find(const ScanFrame& frame, const Pose& last,
                                             const MatchQuality& usual, double reference_s) {
  ++lost_;
  const bool searching = !regions_.empty();
  const bool due = !searching && candidates_.empty() && lost_ >= next_search_;
  if (memory_->empty() || !(searching || due || !candidates_.empty())) return std::nullopt;
  image_.Make(frame.scan);
  check_.SetScan(frame, image_);
  FollowCandidates(frame, reference_s, usual);
  last_ns_ = frame.stamp_ns;
  if (due) BeginSearch();
  if (!regions_.empty()) SearchSome(TiltOf(T_level_odom_ * last), reference_s, usual);
  MergeCandidates();
  if (!regions_.empty()) return std::nullopt;
  std::optional<MatchResult> match = DecidePlace();
  if (match) match->pose.T_odom_sensor = T_level_odom_.Inverse() * match->pose.T_odom_sensor;
  return match;
}

WallsSeen Relocaliser::Walls(const ScanFrame& frame, const Pose& T_odom_sensor) {
  image_.Make(frame.scan);
  return check_.Walls(*memory_, image_, T_level_odom_ * T_odom_sensor);
}

void Relocaliser::BeginSearch() {
  sensors_ = memory_->SensorPositions();
  for (const Eigen::Vector3d& sensor : sensors_) {
    for (const double dx : {-options_.reach_m, options_.reach_m}) {
      for (const double dy : {-options_.reach_m, options_.reach_m}) {
        regions_.push_back({static_cast<int>(std::floor((sensor.x() + dx) / options_.region_m)),
                            static_cast<int>(std::floor((sensor.y() + dy) / options_.region_m))});
      }
    }
  }
  std::sort(regions_.begin(), regions_.end());
  regions_.erase(std::unique(regions_.begin(), regions_.end()), regions_.end());
  exhaustive_ = true;
}

// Goes on with the search until the scan's share of work is done.
void Relocaliser::SearchSome(const Eigen::Quaterniond& tilt, double reference_s,
                             const MatchQuality& usual) {
  const std::vector<Eigen::Vector2f> walls = image_.Walls(
      tilt.toRotationMatrix().cast<float>(), static_cast<float>(options_.wall_spacing_m),
      static_cast<float>(options_.view_m));
  if (static_cast<int>(walls.size()) < options_.min_walls) {
    regions_.clear();
    exhaustive_ = false;
  }
  size_t lookups = 0;
  while (!regions_.empty() && lookups < options_.lookups_per_scan) {
    const Region region = regions_.back();
    regions_.pop_back();
    const WallImage image = MakeWallImage(
        *memory_, sensors_, options_.region_m * Eigen::Vector2d(region.x + 1e-6, region.y + 1e-6),
        options_.region_m, options_.view_m, options_.reach_m);
    const PoseSearchResult result = SearchPoses(image, walls, options_.search);
    lookups += result.lookups;
    exhaustive_ = exhaustive_ && result.complete;
    for (const FoundPose& found : result.found) InspectPlace(found, tilt, reference_s, usual);
  }
  if (!regions_.empty()) return;
  spacing_ = std::min(static_cast<int>(std::ceil(options_.spacing_growth * spacing_)),
                      options_.max_spacing);
  next_search_ = lost_ + spacing_;
}

double Relocaliser::HeightAt(const Eigen::Vector2d& position) const {
  double nearest2 = std::numeric_limits<double>::infinity();
  double height = 0;
  for (const Eigen::Vector3d& sensor : sensors_) {
    const double distance2 = (sensor.head<2>() - position).squaredNorm();
    if (distance2 >= nearest2) continue;
    nearest2 = distance2;
    height = sensor.z();
  }
  return height;
}

void Relocaliser::InspectPlace(const FoundPose& found, const Eigen::Quaterniond& tilt,
                               double reference_s, const MatchQuality& usual) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(found.yaw, Eigen::Vector3d::UnitZ()));
  ScanPose guess;
  guess.T_odom_sensor =
      Pose(turn * tilt, {found.position.x(), found.position.y(), HeightAt(found.position)});
  guess.reference_s = reference_s;
  Candidate candidate;
  candidate.score = found.score;
  ScoreCandidate(check_.Check(*memory_, guess, true), usual, &candidate);
  if (candidate.scans > 0) candidates_.push_back(std::move(candidate));
}

bool Relocaliser::IsStrict(const PlaceMatch& place, double score, const MatchQuality& usual) const {
  const double agreement =
      std::max(options_.least_agreement, options_.min_agreement * usual.agreement());
  const double share = std::max(options_.least_share, options_.min_share * usual.share());
  return score >= options_.min_score && !place.match.degeneracy.any() &&
         place.match.agreement >= agreement && place.share >= share &&
         place.walls.through_share() <= usual.through() + options_.more_through;
}

// Adds a scan to what is known of a place; `scans` becomes 0 if it is out of the question.
void Relocaliser::ScoreCandidate(const PlaceMatch& place, const MatchQuality& usual,
                                 Candidate* candidate) const {
  const double agreement =
      std::max(options_.least_agreement, options_.min_agreement * usual.agreement());
  if (!place.match.pose.T_odom_sensor.IsFinite() ||
      place.match.agreement < kFollowedShare * agreement ||
      place.share < kFollowedShare * options_.least_share) {
    candidate->scans = 0;
    return;
  }
  candidate->match = place.match;
  ++candidate->scans;
  candidate->agreement += place.match.agreement;
  candidate->share += place.share;
  candidate->through += place.walls.through_share();
  candidate->sure = IsStrict(place, candidate->score, usual) ? candidate->sure + 1 : 0;
}

// Takes every place on to the new scan, and drops those where it does not fit.
void Relocaliser::FollowCandidates(const ScanFrame& frame, double reference_s,
                                   const MatchQuality& usual) {
  const double elapsed_s = 1e-9 * static_cast<double>(frame.stamp_ns - last_ns_);
  if (elapsed_s > kFollowGapS) {
    candidates_.clear();
    regions_.clear();
    return;
  }
  for (Candidate& candidate : candidates_) {
    ScanPose guess = candidate.match.pose;
    guess.T_odom_sensor = guess.At(elapsed_s + reference_s);
    guess.reference_s = reference_s;
    ScoreCandidate(check_.Check(*memory_, guess, false), usual, &candidate);
    if (candidate.scans == 0) continue;
    const Pose surprise = guess.T_odom_sensor.Inverse() * candidate.match.pose.T_odom_sensor;
    if (surprise.translation().norm() > options_.max_surprise_m ||
        RotationAngle(surprise) > options_.max_surprise_rad) {
      candidate.scans = 0;
    }
  }
  std::erase_if(candidates_, [](const Candidate& candidate) { return candidate.scans == 0; });
}

// Different guesses may have led to one place; the best are kept.
void Relocaliser::MergeCandidates() {
  std::stable_sort(candidates_.begin(), candidates_.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  std::vector<Candidate> merged;
  for (Candidate& candidate : candidates_) {
    const bool known = std::any_of(merged.begin(), merged.end(), [&](const Candidate& other) {
      return AreNear(other.match.pose.T_odom_sensor, candidate.match.pose.T_odom_sensor,
                     kSamePlaceM, kSamePlaceRad);
    });
    if (!known && static_cast<int>(merged.size()) < options_.max_candidates) {
      merged.push_back(std::move(candidate));
    }
  }
  candidates_.swap(merged);
}

bool Relocaliser::IsRival(const Candidate& other, const Candidate& best) const {
  const double through = best.through / best.scans;
  return other.score >= kRivalScore * best.score &&
         other.agreement / other.scans >= kRivalAgreement * best.agreement / best.scans &&
         other.share / other.scans >= kRivalShare * best.share / best.scans &&
         other.through / other.scans <=
             std::max(kRivalThroughFactor * through, through + kRivalThroughMore);
}

std::optional<MatchResult> Relocaliser::DecidePlace() {
  const auto best =
      std::max_element(candidates_.begin(), candidates_.end(),
                       [](const Candidate& a, const Candidate& b) { return a.sure < b.sure; });
  contested_ = false;
  if (best == candidates_.end()) return std::nullopt;
  const bool contested = std::any_of(
      candidates_.begin(), candidates_.end(),
      [&](const Candidate& other) { return &other != &*best && IsRival(other, *best); });
  contested_ = contested && best->sure >= options_.confirmations;
  if (best->sure >= options_.confirmations && !contested && exhaustive_) return best->match;
  const bool given_up = best->scans >= options_.max_followed;
  const bool hopeless = best->sure == 0 && best->scans > 2 * options_.confirmations;
  if (given_up || hopeless) {
    candidates_.clear();
    next_search_ = lost_ + spacing_;
  }
  return std::nullopt;
}

}  // namespace isthmus::floam
