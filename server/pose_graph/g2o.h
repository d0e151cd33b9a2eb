// Pose graphs as g2o's text files: VERTEX_SE3:QUAT, EDGE_SE3:QUAT and FIX.
//
// g2o's error of an edge is the vector [t; q] of M^-1 T_a^-1 T_b, with q the vector part of the
// unit quaternion, half the rotation vector of a small turn; ours is a twist on the left of M.
// Information is converted between the two, exactly for small errors. (Some programs read q as a
// rotation vector; information then differs by 4 in the rotation block.)
#pragma once

#include <cstdint>
#include <istream>
#include <ostream>
#include <vector>

#include "absl/status/statusor.h"
#include "server/pose_graph/problem.h"

namespace isthmus::pose_graph {

struct G2oGraph {
  Problem problem;           // No edge is in doubt, there are no anchors: the format has neither.
  std::vector<int64_t> ids;  // The file's name of each node, ascending; any numbers.
};

// InvalidArgument, naming the line, for text that is damaged or cut off, numbers that are not
// finite, quaternions of no length, vertices given twice or edges between unknown ones, information
// that is none, and tags that are unknown; planar graphs (VERTEX_SE2) are refused too. Empty lines,
// comments (#) and PARAMS_ lines are passed over. Vertices and edges may come in any order.
absl::StatusOr<G2oGraph> ReadG2o(std::istream& input);

// Writes the poses, edges and fixed nodes with 17 digits, so that reading gives them back but for
// rounding. Anchors become edges from one more vertex, fixed at the origin of the map. `ids` names
// the nodes; empty: by their indices. InvalidArgument when it is of another length or an index is
// out of range; Unavailable when the stream fails.
absl::Status WriteG2o(const Problem& problem, const std::vector<int64_t>& ids,
                      std::ostream& output);

// Information of [t; q] as g2o has it from that of an Edge with this T_a_b, and back.
Matrix6d ToG2oInformation(const Matrix6d& information, const Pose& T_a_b);
Matrix6d FromG2oInformation(const Matrix6d& g2o, const Pose& T_a_b);

}  // namespace isthmus::pose_graph
