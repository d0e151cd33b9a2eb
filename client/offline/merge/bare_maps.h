// Maps without sensor poses: nothing tells what was seen to be free, so no match of theirs can be
// verified.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "client/library/client.h"
#include "client/offline/merge/merge_input.h"

namespace isthmus::cli {

// One sentence per map that came without sensor poses: what is lacking and how to supply it.
std::vector<std::string> WhatIsLacking(const std::vector<MergeInput>& inputs);

// Takes the pairs that have such a map out of the map that the server makes; or, if `unverified`,
// joins by the best alignments that were found of them what nothing better joins. `graph` is the
// server's before, with rivals; returns its matches as they are to be reported: those pairs as
// NOT_YET with the reason NO_POSES, ACCEPTED with UNVERIFIED, or AMBIGUOUS where a rival is as good
// as the best. Of the numbers that rest on sensor poses the probability stays, which was computed
// from guessed places.
absl::StatusOr<std::vector<MatchEdge>> DecideBarePairs(client::Client& client,
                                                       const MatchGraph& graph,
                                                       const std::vector<MergeInput>& inputs,
                                                       bool unverified);

// True if DecideBarePairs left the pair apart because another alignment is as good.
bool IsRefused(const MatchEdge& edge, const std::vector<MergeInput>& inputs);

}  // namespace isthmus::cli
