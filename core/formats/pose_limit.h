// The limit of what files of poses may claim.
#pragma once

namespace isthmus::formats {

// Metres: no pose on Earth is farther from where its frame begins. Squares and sums of what is
// larger overflow, and errors of trajectories are no numbers then.
inline constexpr double kMaxPoseM = 1e9;

}  // namespace isthmus::formats
