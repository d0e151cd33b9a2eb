// Group hypotheses: transforms between two frames, and the hypotheses that support each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/match_graph/evidence.h"
#include "server/match_graph/rigid_groups.h"

namespace isthmus::match_graph {

// A hypothesis between two frames, seen from the first of them.
struct FrameConstraint {
  const Hypothesis* hypothesis = nullptr;
  uint32_t from = 0, to = 0;  // Nodes of the first and the second frame.
  Pose T_from_to;
  Pose T_first_second;                              // Between the frames.
  std::vector<Eigen::Vector3d> ground, far_ground;  // In the first frame and in the second.
};

struct GroupHypothesis {
  FrameConstraint constraint;                       // The hypothesis that the others agree with.
  std::vector<const Hypothesis*> members;           // All of them; of a pair at most one.
  std::vector<Eigen::Vector3d> ground, far_ground;  // Ground of all members.
  size_t grounds = 0;                               // Number of different places that they rest on.
  double log_odds = 0;                              // Against no group hypothesis' being right.
  double probability = 0;  // Beside all group hypotheses on the two frames.
};

// The ways in which hypotheses join frames. Keeps references to what it is given. Not thread safe.
class GroupHypotheses {
 public:
  GroupHypotheses(const Evidence& evidence, const RigidGroups& rigid_groups,
                  const GroupOptions& options)
      : evidence_(evidence), rigid_groups_(rigid_groups), options_(options) {}

  // Group hypotheses on two frames, from the hypotheses of the pairs between them: the most
  // probable first; none that free space or a person contradicts.
  std::vector<GroupHypothesis> Between(uint32_t x, const std::vector<const OpenPair*>& pairs) const;

  // The way round by a group hypothesis and back by another of its members.
  std::vector<Step> StepsBack(const FrameConstraint& constraint, const Hypothesis& by) const;
  // The way round three frames by group hypotheses on x ~ y, y ~ z and x ~ z.
  std::vector<Step> StepsRound(const FrameConstraint& xy, const FrameConstraint& yz,
                               const FrameConstraint& xz) const;
  // A quick look: false where that way cannot close.
  bool MayClose(const FrameConstraint& xy, const FrameConstraint& yz,
                const FrameConstraint& xz) const;
  // The way by the hypothesis and back by the joints of its frame.
  std::vector<Step> StepsBack(const Hypothesis& hypothesis) const;

 private:
  FrameConstraint MakeConstraint(const Hypothesis& hypothesis, uint32_t first) const;
  double MostDegrees() const;  // The most that any way round may leave.
  std::vector<Step> StepsBetween(const FrameConstraint& p, const FrameConstraint& q) const;
  bool Agree(const FrameConstraint& p, const FrameConstraint& q) const;
  bool IsContradicted(const FrameConstraint& constraint,
                      const std::vector<const OpenPair*>& pairs) const;
  GroupHypothesis MakeGroup(const std::vector<FrameConstraint>& constraints, size_t center) const;

  const Evidence& evidence_;
  const RigidGroups& rigid_groups_;
  const GroupOptions options_;
};

}  // namespace isthmus::match_graph
