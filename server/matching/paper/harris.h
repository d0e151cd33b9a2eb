// Harris 3D key points: Sipiran and Bustos, "Harris 3D: a robust extension of the Harris operator
// for interest point detection on 3D meshes", The Visual Computer 27, 2011, in PCL's form, which
// takes the covariance of the normals instead of image gradients.
#pragma once

#include <vector>

#include "server/matching/paper/feature_chain_options.h"
#include "server/matching/paper/normals.h"

namespace isthmus::matching {

// Indices of the points where normals point many ways: corners of walls, floor and furniture. In
// ascending order. May throw what PCL throws.
std::vector<int> DetectHarrisKeypoints(const OrientedPoints& points, const HarrisOptions& options);

}  // namespace isthmus::matching
