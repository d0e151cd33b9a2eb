// Pairs of sessions that are open by themselves, settled by three and more sessions together.
#pragma once

#include <vector>

#include "core/map/match.h"
#include "server/match_graph/group_options.h"
#include "server/match_graph/match_graph.h"

namespace isthmus::match_graph {

// Accepts open matches (reason "GROUP", a detail that names the sessions, the group's probability
// as confidence) where of all ways in which the sessions' maps may lie on each other, rivals
// included, one is by far the most probable. A match whose rival is taken changes places with it.
// Call it after CheckCycles.
//
// Accepted matches lay sessions in frames; those are not questioned. Two frames are joined where
// hypotheses between them agree (within what cycles leave open) that rest on different ground, each
// counted with its odds, and beyond the first with the odds against agreeing by chance; hypotheses
// on the same ground err together, as in a room that has a twin, and count once. Three frames are
// joined at once where hypotheses close the way round them and no error of one frame's place
// explains that as well. All that disagrees counts against it. Nothing is joined over a hypothesis
// that free space or a person contradicts, nor by a single one. At last open matches within a frame
// that agree with it are accepted.
//
// What is settled so lasts as long as what it rests on: every call begins anew. Deterministic: the
// order of nodes and matches does not matter. Thread safe (no shared state).
void SettleGroups(const std::vector<Node>& nodes, const GroupOptions& options,
                  std::vector<Match>* matches);

}  // namespace isthmus::match_graph
