// Statistical outlier removal: Rusu et al., "Towards 3D Point Cloud Based Object Maps for Household
// Environments", Robotics and Autonomous Systems 56, 2008, section 4.1.
#pragma once

#include <vector>

#include "server/matching/paper/feature_chain_options.h"
#include "server/matching/registration/voxel_filter.h"

namespace isthmus::matching {

// The points whose mean distance to their neighbours is not unusual, in the order given. May throw
// what PCL throws.
std::vector<ViewedPoint> RemoveOutliers(const std::vector<ViewedPoint>& points,
                                        const OutlierRemovalOptions& options);

}  // namespace isthmus::matching
