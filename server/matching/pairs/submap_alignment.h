// The alignment of one submap with another: an edge for a pose graph.
#pragma once

#include <optional>

#include "core/pose.h"
#include "server/matching/prepared/prepared_submap.h"

namespace isthmus::matching {

struct SubmapAlignment {
  Pose T_a_b;
  // The information of the twist [rho; phi] in frame a by which the truth is Exp(twist) T_a_b; none
  // along directions that slide. Neighbouring points err together, so that it does not grow with
  // their number: where all directions are held well a standard deviation is about a centimetre.
  Matrix6d information = Matrix6d::Zero();
  int inliers = 0;
};

// GICP (gicp.h) of b's sample on a's surface, from `guess_T_a_b`, with pairs up to `gate_m`.
// Nothing where too few points meet, the alignment does not settle near the guess, or the two lie
// on different levels: most of what faces up or down in one, and is near the other, lies on none of
// its surfaces. Up is as the submaps' odometry has it. Deterministic. Thread safe.
std::optional<SubmapAlignment> AlignSubmaps(const PreparedSubmap& a, const PreparedSubmap& b,
                                            const Pose& guess_T_a_b, double gate_m);

}  // namespace isthmus::matching
