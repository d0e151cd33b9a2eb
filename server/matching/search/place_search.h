// Candidates from places that look alike: cheap, and good wherever both robots passed within a
// metre or two of the same spot. Where their ways only come near each other, look to the bird's-eye
// search.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "core/map/submap.h"
#include "core/pose.h"
#include "server/matching/registration/candidate.h"
#include "server/matching/search/place_descriptor.h"

namespace isthmus::matching {

struct Place {
  Pose T_odom_place;  // The place's frame is level and has its origin at the sensor.
  PlaceDescriptor descriptor;
};

// The sensor's places at `count` keyframes spread over the submap, each described by all points of
// the submap. Fewer for submaps with fewer keyframes. Some 2 ms each for 100,000 points.
std::vector<Place> DescribePlaces(const Submap& submap, const Eigen::Quaterniond& R_level_odom,
                                  const PlaceDescriptorOptions& options = {}, size_t count = 3);

// The at most `limit` candidates with the greatest score, best first, from the pairs of places that
// are nearest to each other, those that put b within 2 m and 12 degrees of a better one left out.
// Score is 1 - distance, source kPlaces. With all places of a and only the new ones of b, it costs
// what the new ones cost. Deterministic; thread safe.
std::vector<Candidate> SearchPlaces(const std::vector<Place>& a, const std::vector<Place>& b,
                                    size_t limit);

}  // namespace isthmus::matching
