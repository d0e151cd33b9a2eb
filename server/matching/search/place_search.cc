#include "server/matching/search/place_search.h"

#include <algorithm>
#include <utility>

#include "server/matching/search/limits.h"

namespace isthmus::matching {
namespace {

struct Guess {
  double distance = 1;
  Pose T_a_b;
  Eigen::Vector3d place_b = Eigen::Vector3d::Zero();  // Place of the comparison, b's odom.
};

// Measured at the place, not at the origin that may be far away.
bool IsSame(const Guess& guess, const Guess& other) {
  return (guess.T_a_b * guess.place_b - other.T_a_b * guess.place_b).norm() < kGuessErrorM &&
         RotationAngle(guess.T_a_b.Inverse() * other.T_a_b) < kSameGuessRad;
}

std::vector<Guess> MakeGuesses(const std::vector<Place>& a, const std::vector<Place>& b) {
  std::vector<PlaceDescriptor> descriptors;
  descriptors.reserve(a.size());
  for (const Place& place : a) descriptors.push_back(place.descriptor);
  std::vector<Guess> guesses;
  for (const Place& place : b) {
    // The hits' yaw is that of b's place against a's, from a's to b's frame.
    for (const PlaceHit& hit : FindPlaces(place.descriptor, descriptors, kHitsPerPlace)) {
      const Eigen::AngleAxisd turn(-hit.comparison.yaw, Eigen::Vector3d::UnitZ());
      const Pose T_place_a_place_b(Eigen::Quaterniond(turn), Eigen::Vector3d::Zero());
      guesses.push_back(
          {hit.comparison.distance,
           a[hit.place].T_odom_place * T_place_a_place_b * place.T_odom_place.Inverse(),
           place.T_odom_place.translation()});
    }
  }
  std::stable_sort(guesses.begin(), guesses.end(),
                   [](const Guess& x, const Guess& y) { return x.distance < y.distance; });
  return guesses;
}

}  // namespace

std::vector<Place> DescribePlaces(const Submap& submap, const Eigen::Quaterniond& R_level_odom,
                                  const PlaceDescriptorOptions& options, size_t count) {
  count = std::min(count, submap.keyframes.size());
  std::vector<Place> places;
  std::vector<Eigen::Vector3f> points;
  for (size_t i = 0; i < count; ++i) {
    const Keyframe& keyframe =
        submap.keyframes[submap.keyframes.size() * (2 * i + 1) / (2 * count)];
    Place place;
    place.T_odom_place =
        Pose(R_level_odom.inverse(), submap.T_odom_submap * keyframe.T_submap_sensor.translation());
    const Pose T_place_submap = place.T_odom_place.Inverse() * submap.T_odom_submap;
    const Eigen::Matrix3f R = T_place_submap.RotationMatrix().cast<float>();
    const Eigen::Vector3f t = T_place_submap.translation().cast<float>();
    points.clear();
    for (const SubmapPoint& point : submap.points) points.push_back(R * point.Position() + t);
    place.descriptor = DescribePlace(points, options);
    places.push_back(std::move(place));
  }
  return places;
}

std::vector<Candidate> SearchPlaces(const std::vector<Place>& a, const std::vector<Place>& b,
                                    size_t limit) {
  std::vector<Guess> kept;
  for (const Guess& guess : MakeGuesses(a, b)) {
    if (kept.size() >= limit) break;
    const bool known = std::any_of(kept.begin(), kept.end(),
                                   [&](const Guess& better) { return IsSame(guess, better); });
    if (!known) kept.push_back(guess);
  }
  std::vector<Candidate> candidates;
  for (const Guess& guess : kept)
    candidates.push_back({guess.T_a_b, 1 - guess.distance, GuessSource::kPlaces});
  return candidates;
}

}  // namespace isthmus::matching
