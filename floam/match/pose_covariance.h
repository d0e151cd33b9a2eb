// The covariance of the pose at the END of a scan, from its match.
#pragma once

#include "core/pose.h"
#include "floam/match/degeneracy.h"
#include "floam/match/scan_matcher.h"

namespace isthmus::floam {

// Covariance of T_odom_sensor at the END of the scan, twist order [rho; phi], sensor frame there,
// from that of pose and twist at the reference time. `with_twist`: the twist was estimated. Not
// large along what was not observed: the guess was held there.
Matrix6d MatchedCovarianceAtEnd(const MatchResult& match, bool with_twist);

// The directions in which the map leaves the pose at the reference time unobserved, as seen at the
// END of the scan.
Degeneracy DegeneracyAtEnd(const MatchResult& match);

// Wide along what was not observed, both in the sensor frame at the END of the scan.
Matrix6d Widened(const Matrix6d& covariance, const Degeneracy& unobserved);

// The covariance of a pose that is only predicted.
Matrix6d LostCovariance();

}  // namespace isthmus::floam
