// The difference between the last graphs and the new ones.
#pragma once

#include <map>
#include <vector>

#include "server/placement/graph.h"
#include "server/placement/placer.h"

namespace isthmus::placement {

struct KeptAnchor {
  Anchor anchor;
  double weight = 1;
};

// The graphs and placements of one call.
struct LastGraphs {
  GraphSet set;                            // With the weights that were found.
  std::vector<Placement> placements;       // As published.
  std::map<SubmapId, KeptAnchor> anchors;  // Anchors of submaps that are in the map.
  std::map<SessionId, bool> anchored;      // By reference.
};

struct GraphDiff {
  // Something went away that may have bent the map: a match, a loop, an anchor, a session. Submaps
  // that were retired took nothing with them that was wrong.
  bool anew = false;
  bool unknown = false;    // None of its sessions was there.
  bool joined = false;     // Parts that did not hang together, or were not known, do now.
  bool new_match = false;  // A match, or a person's decision on one.
  // An anchor is new; or the map frame is the anchors' from now on.
  bool new_anchor = false;
  // Some edges of a match went away while others of it stand.
  bool loosened = false;
  // Edges that are new, changed, or next to loosened ones.
  std::vector<int> edges;
};

// The changes of each of the graphs.
std::vector<GraphDiff> DiffGraphs(const LastGraphs& last, const Input& input,
                                  const SessionNumbers& numbers, const GraphSet& now);

// Gives edges and anchors the weights that the same ones had then.
void InheritWeights(const LastGraphs& last, const Input& input, Graph* graph);

}  // namespace isthmus::placement
