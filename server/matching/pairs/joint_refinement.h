// A hypothesis about two maps refined together with what both robots know of their own way,
// odometry and loops: every submap may move, the more the less it contradicts these. A drifted map
// cannot be laid rigidly on another; judged so, the right place may look worse than a wrong one.
#pragma once

#include <vector>

#include "core/map/match.h"
#include "server/matching/prepared/map_poses.h"
#include "server/matching/prepared/prepared_map.h"

namespace isthmus::matching {

struct JointRefinement {
  MapPoses poses;  // The first submap of a that an edge touches keeps its place.
  // Submaps of a on submaps of b, as aligned with each other. Until matching hands them out, their
  // submap_a and submap_b are positions in the maps at hand and not, as elsewhere, indices in the
  // sessions, which have gaps where submaps were retired.
  std::vector<SubmapEdge> edges;
  // RMS of the odometry's errors in its standard deviations; with loops, of what it errs more than
  // they make it anyway, and the loops' own errors with it.
  double odometry_residual = 0;
  // One transform between the frames of the maps for all: where the edges of their longest stretch
  // want it, as none suits both ends of a drifted way.
  Pose T_a_b;
  // Edges that were found along both ways (loops/meetings.h), farther off than submaps that are
  // aligned may be. They are kept, and count beside the others, whatever is made anew.
  std::vector<SubmapEdge> ties = {};
};

// Begins at `poses` and adds to `edges` those of pairs of submaps of which one is new (at or beyond
// `first_a`, `first_b`); with zeros all edges are made anew, and where there are ties the
// poses follow these first, and the edges that there were along the longest stretch. `gate_m` is
// how far off pairs of points may be at first. Of every submap of b the few nearest of a are tried.
// False, with nothing changed, when no submaps could be aligned. Deterministic. Thread safe.
bool RefineJointly(const PreparedMap& a, const PreparedMap& b, double gate_m, size_t first_a,
                   size_t first_b, JointRefinement* joint);

// The edges, positions on positions, of the longest stretch where the maps lie side by side: from
// each to another it is a few submaps of either map.
std::vector<SubmapEdge> LongestStretch(const std::vector<SubmapEdge>& edges);

}  // namespace isthmus::matching
