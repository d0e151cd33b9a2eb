// A guess about a pair of maps with all that was measured of it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/map/match.h"
#include "server/matching/pairs/joint_refinement.h"
#include "server/matching/prepared/free_space.h"
#include "server/matching/prepared/prepared_map.h"
#include "server/matching/prepared/surface_agreement.h"
#include "server/matching/prepared/things.h"

namespace isthmus::matching {

// Submaps of a and b, by their positions in the maps.
struct PositionPair {
  uint32_t a = 0, b = 0;
};

// The state of the search for further places where two joined maps meet (loops/meetings.h).
struct MeetingMemory {
  size_t asked_a = 0, asked_b = 0;    // Submaps from here on were never asked.
  std::vector<PositionPair> in_vain;  // They were looked at and do not meet.
};

// The result of such a search.
struct Meetings {
  std::vector<SubmapEdge> ties;  // Positions of a on positions of b.
  double max_free_space = 0;     // Share that may be contradicted once the maps meet there.
  MeetingMemory memory;
};

struct Hypothesis {
  GuessSource source = GuessSource::kNone;
  bool outdoors = false;   // The pair is looked at as outdoors.
  Pose T_a_b;              // Between the odom frames as the maps have them: straightened by loops.
  bool converged = false;  // Its refinement settled.
  FreeSpaceScore free_space;
  double max_free_space = 0;  // The limit that holds for a loop; 0: none was set.
  double overlap = 0;         // As in Match.
  int64_t inliers = 0;
  double inlier_ratio = 0;
  double residual_m = 0;
  int64_t distinctive = 0;  // Inliers that neither map's repeats explain.
  ThingAgreement things;  // Each map's in the other; none outdoors, where they are not looked for.
  double upright_ratio = 0;    // As inlier_ratio, of what stands upright.
  SurfaceAgreement own;        // Each session with itself: the agreement to expect here.
  bool can_be_refuted = true;  // Both maps say what their robots looked through.
  bool upside_down = false;    // One robot's odometry hangs from the other's ceiling.
  double at_anchors = 0;  // Log odds of anchors: here against anywhere else (AnchorPrior::LogOdds).
  double by_anchors = 0;  // The part that counts: other places are as near to the anchors.
  double repetition = 0;  // Degree to which the map that repeats more lies on itself elsewhere.
  double shared_area_m2 = 0;  // Ground that both robots looked across.
  double shared_share = 0;    // Its share of all that the robot that saw more saw.
  // Mean squared component of the inliers' normals along the direction in which the alignment is
  // held least; 0: it slides.
  double observability = 0;
  double odometry_residual = 0;  // As in Match.

  // Support of free space at the limit: loops are ranked by it.
  double Support() const;

  // Ranks rigid alignments: the log of how much lies on the other map, less what free space
  // contradicts.
  double Promise() const;

  // Share of points on the other map, less where they lie on it loosely: as if at random within the
  // distance at which they count, nothing is left.
  double Agreement() const;

  // --- what it was measured at, to be added to when the maps have grown ---
  JointRefinement joint;
  // Center of the shared ground, a's odom frame.
  Eigen::Vector3d shared_center = Eigen::Vector3d::Zero();
  bool moving_is_b = true;  // The agreement is of b's surface, else of a's: the smaller map's.
  std::vector<SurfaceAgreement> agreement;         // By its submaps.
  std::vector<ThingAgreement> things_a, things_b;  // By submaps.
  MeetingMemory meetings;
};

// Puts the one of the most support first.
void RankHypotheses(std::vector<Hypothesis>* hypotheses);

// Returns those rigid ones that promise most and are worth a joint refinement. Leaves `found`
// ranked.
std::vector<Hypothesis> MostPromising(std::vector<Hypothesis>* found);

// Alignments nearer to each other than 1 m and 5 degrees, where b's points are (`middle_b`, b's
// odom frame), are one hypothesis.
bool IsSameAlignment(const Pose& T_a_b, const Pose& other_T_a_b, const Eigen::Vector3d& middle_b);

// Other alignments that what either map repeats would make as good.
std::vector<Pose> MovedByRepeats(const PreparedMap& a, const PreparedMap& b, const Pose& T_a_b);

// After joint refinements: the edges of one lie in the other as they do in it. Guesses that differ
// while rigid may bend into the same place.
bool IsSamePlace(const JointRefinement& joint, const JointRefinement& other);

// Refines jointly from h->T_a_b, or from where its ties and the edges that it had put the maps, and
// measures everything anew but the shared area and what only pairs of sessions are judged by
// (`own`, `distinctive`, `repetition`). Leaves the poses rigid, with `converged` false, where no
// submaps could be aligned.
void MeasureJointly(const PreparedMap& a, const PreparedMap& b, Hypothesis* h);

// The same for two sessions' maps: `own` and `distinctive` too.
void MeasurePair(const PreparedMap& a, const PreparedMap& b, Hypothesis* h);

// The same for maps that have grown by the submaps from `first_a` and `first_b` on: only these and
// what lies around them is looked at, unless the old ones had to move.
void ExtendJointly(const PreparedMap& a, const PreparedMap& b, size_t first_a, size_t first_b,
                   Hypothesis* h);

// The same for maps of which only the submaps at these positions are left. What was measured of the
// others still counts.
void KeepOnly(const std::vector<size_t>& kept_a, const std::vector<size_t>& kept_b, Hypothesis* h);

}  // namespace isthmus::matching
