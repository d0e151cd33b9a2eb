// The search for group hypotheses that are so probable together that they are accepted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "server/match_graph/group_hypotheses.h"

namespace isthmus::match_graph {

// Group hypotheses that are accepted together: one, or three that close (x ~ y, y ~ z, x ~ z).
struct GroupDecision {
  double probability = 0;
  std::vector<const GroupHypothesis*> groups;
};

// Keeps references to what it is given. Not thread safe.
class GroupDecisionSearch {
 public:
  GroupDecisionSearch(const Evidence& evidence, const RigidGroups& rigid_groups,
                      const GroupHypotheses& groups, const GroupOptions& options);

  // The most probable group decision, none where nothing is probable enough: of two frames, or,
  // where there is no such thing, of three. Its group hypotheses last until the next Forget.
  GroupDecision Find();
  // Frames were joined: what was found of these is out of date.
  void Forget(const std::set<uint32_t>& frames);

 private:
  using FramePair = std::pair<uint32_t, uint32_t>;

  void FindGroups();
  GroupDecision FindPair() const;
  GroupDecision FindTriple();
  GroupDecision SettleThree(const std::vector<GroupHypothesis>& xy,
                            const std::vector<GroupHypothesis>& yz,
                            const std::vector<GroupHypothesis>& xz);
  std::optional<double> OddsOfWrong(const GroupHypothesis& xy, const GroupHypothesis& yz,
                                    const GroupHypothesis& xz);

  const Evidence& evidence_;
  const RigidGroups& rigid_groups_;
  const GroupHypotheses& search_;
  const GroupOptions options_;
  const double least_two_;  // Log odds that the two least certain of three must have together.
  std::map<FramePair, std::vector<GroupHypothesis>> groups_;
  size_t triples_ = 0;  // Looked at so far.
};

}  // namespace isthmus::match_graph
