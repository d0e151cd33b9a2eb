// Pose graphs as g2o's text files: VERTEX_SE3:QUAT, EDGE_SE3:QUAT, VERTEX_SE2, EDGE_SE2 and FIX.
//
// g2o's error of an edge is the vector [t; q] of M^-1 T_a^-1 T_b, with q the vector part of the
// unit quaternion, half the rotation vector of a small turn; ours is a twist on the left of M.
// Information is converted between the two, exactly for small errors. (Some programs read q as a
// rotation vector; information then differs by 4 in the rotation block.) A planar graph (SE2) is
// lifted to the plane z = 0, with as much information off the plane as in it.
#pragma once

#include <cstdint>
#include <istream>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/pose_graph/problem.h"

namespace isthmus::pose_graph {

struct G2oGraph {
  Problem problem;           // No edge is in doubt, there are no anchors: the format has neither.
  std::vector<int64_t> ids;  // The file's name of each node, ascending; any numbers.
  bool is_planar = false;    // All of it was SE2.
  // Nodes without a vertex line. Edges lead to their poses, from the nodes that have one, or else
  // from the lowest id, which is put at the origin; between neighbouring ids first (odometry).
  size_t placed_by_edges = 0;
  // The number of lines that were left out, by their kind: a tag that is not one of the above, an
  // edge whose information is not finite or negative along a direction, an edge from a vertex to
  // itself, a FIX of a vertex that is none of the nodes.
  std::map<std::string, size_t> left_out;
};

// InvalidArgument, naming the line, for text that is damaged or cut off, poses that are not finite,
// quaternions of no length, vertices given twice; and where there is no vertex and no edge. Empty
// lines, comments (#) and PARAMS_ lines are passed over. Lines may come in any order.
absl::StatusOr<G2oGraph> ReadG2o(std::istream& input);

// The poses of vertex lines alone, in order of their ids; all other lines are passed over unread.
// InvalidArgument for damaged vertex lines.
absl::StatusOr<std::vector<Pose>> ReadG2oVertices(std::istream& input);

// Writes the poses, edges and fixed nodes with 17 digits, so that reading gives them back but for
// rounding; as SE2 if that is asked for. Anchors become edges from one more vertex, fixed at the
// origin of the map. `ids` names the nodes; empty: by their indices. InvalidArgument when it is of
// another length or an index is out of range; Unavailable when the stream fails.
absl::Status WriteG2o(const Problem& problem, const std::vector<int64_t>& ids, std::ostream& output,
                      bool is_planar = false);

// Information of [t; q] as g2o has it from that of an Edge with this T_a_b, and back.
Matrix6d ToG2oInformation(const Matrix6d& information, const Pose& T_a_b);
Matrix6d FromG2oInformation(const Matrix6d& g2o, const Pose& T_a_b);

// The errors of a graph as others tell them, to compare with their figures.
struct PublicCosts {
  // The sum of e^T information e, with e the full [t; q] above, or [t; angle] of a planar graph: as
  // g2o prints it. Agrees with Chi2 where errors are small.
  double g2o = 0;
  // The objective of SE-Sync (Rosen et al., IJRR 2019, eq. 17): chordal distances with one weight
  // each for rotation and translation, the means of the file's variances. The file's rotation block
  // is taken for that of rotation vectors.
  double se_sync = 0;
};
// `weights` of the edges, as many; an edge of weight 0 costs nothing.
PublicCosts CostsOfOthers(const Problem& problem, const std::vector<double>& weights,
                          bool is_planar);

}  // namespace isthmus::pose_graph
