// The alignment of one submap with another: an edge for a pose graph, and the numbers of the
// alignment.
#pragma once

#include <optional>
#include <vector>

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
// Nothing where too few points meet or the alignment does not settle near the guess. Deterministic.
// Thread safe.
std::optional<SubmapAlignment> AlignSubmaps(const PreparedSubmap& a, const PreparedSubmap& b,
                                            const Pose& guess_T_a_b, double gate_m);

// The agreement of a submap's surface with a whole map. Sums, so that those of submaps can be
// added.
struct SurfaceAgreement {
  int64_t asked = 0;      // Points of the submap that were asked,
  int64_t near = 0;       // that have the map within a metre,
  int64_t on = 0;         // that lie on it,
  double squared_m2 = 0;  // and the squared distances of these along the normals.
  // Sum over the points on it of J^T n n^T J, J = [I, -[p]x], p in the common frame: the
  // information of a twist about its origin per squared metre.
  Matrix6d scatter = Matrix6d::Zero();

  SurfaceAgreement& operator+=(const SurfaceAgreement& other);
};

// An even sample of the submap's points against all of `map`. `T_common_submap` and `T_common_map`
// place them in one frame. A point lies on the map when it has a neighbour there whose normal is
// within 60 degrees, within `distance_m` along that normal, and within that or a voxel across.
SurfaceAgreement MeasureAgreement(const PreparedSubmap& submap, const Pose& T_common_submap,
                                  const PreparedSubmaps& map, const std::vector<Pose>& T_common_map,
                                  double distance_m);

}  // namespace isthmus::matching
