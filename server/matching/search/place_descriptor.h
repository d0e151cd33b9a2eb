// A descriptor of a place as seen from above, in so few numbers that hundreds of places are
// compared in a millisecond or two: a cheap guess at where two robots may have been near each
// other.
//
// After Kim & Kim, "Scan Context: Egocentric Spatial Descriptor for Place Recognition within 3D
// Point Cloud Map", IROS 2018: rings and sectors round the place, in each cell the greatest height,
// and a key per ring that does not depend on the heading. Two things differ. The cells are blurred
// and all of them compared at once, each by its area, instead of sector by sector: a shift of the
// place by some metres changes the near cells beyond recognition and the far ones hardly. And only
// heights within a band count, as indoors the greatest height is the ceiling's everywhere.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "server/matching/search/limits.h"

namespace isthmus::matching {

struct PlaceDescriptorOptions {
  double max_range_m = 60;  // Walls farther away do not count.
  // The band of z in which points count, in the frame of the points. These are for z relative to a
  // sensor that is about a metre above the floor; outdoors 0.2 to 7 m leave out cars and hedges.
  float low_m = -0.3f, high_m = 2.7f;
};

// Value type. Comparable with those of the same options only.
struct PlaceDescriptor {
  // Sector by sector from azimuth -pi, rings outwards; not negative, of unit length as a whole, or
  // all 0 where there was nothing in the band.
  std::array<float, kPlaceRings* kPlaceSectors> cells = {};
  // Mean height of each ring, as a share of the band.
  std::array<float, kPlaceRings> ring_key = {};

  bool empty() const;
};

// `points` in a level frame (z up) whose origin is the place's centre: where the sensor stood in
// the middle of a submap. Points that are not finite do not count, nor does their order.
PlaceDescriptor DescribePlace(const std::vector<Eigen::Vector3f>& points,
                              const PlaceDescriptorOptions& options = {});

struct PlaceComparison {
  double distance = 1;  // [0, 1]; 0 for the same place turned by whole sectors.
  double yaw = 0;  // Yaw of T_a_b, takes b's frame to a's; (-pi, pi], in steps of a sector (6 deg).
};

// The best of all turns. Symmetric but for the sign of yaw. Distance 1 if either is empty. Some 10
// microseconds.
PlaceComparison Compare(const PlaceDescriptor& a, const PlaceDescriptor& b);

struct PlaceHit {
  size_t place = 0;            // Index into the places asked.
  PlaceComparison comparison;  // a: the query, b: the place.
};

// The at most k places nearest to the query, nearest first: those whose ring keys are nearest are
// compared, at least kMinShortlist and kShortlistPerHit for each of k; equal ones in order of
// index. Empty ones are never returned. Deterministic; thread safe. O(places) in ring keys.
std::vector<PlaceHit> FindPlaces(const PlaceDescriptor& query,
                                 const std::vector<PlaceDescriptor>& places, size_t k);

}  // namespace isthmus::matching
