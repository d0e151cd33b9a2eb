// Claims: transforms between two frames, and the hypotheses that support each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "server/match_graph/evidence.h"
#include "server/match_graph/frames.h"

namespace isthmus::match_graph {

// A hypothesis between two frames, seen from the first of them.
struct Link {
  const Hypothesis* hypothesis = nullptr;
  uint32_t from = 0, to = 0;  // Nodes of the first and the second frame.
  Pose T_from_to;
  Pose T_first_second;                              // Between the frames.
  std::vector<Eigen::Vector3d> ground, far_ground;  // In the first frame and in the second.
};

struct Claim {
  Link link;                                        // The hypothesis that the others agree with.
  std::vector<const Hypothesis*> members;           // All of them; of a pair at most one.
  std::vector<Eigen::Vector3d> ground, far_ground;  // Ground of all members.
  size_t grounds = 0;                               // Number of different places that they rest on.
  double log_odds = 0;                              // Against no claim's being right.
  double probability = 0;                           // Beside all claims on the two frames.
};

// The ways in which hypotheses join frames. Keeps references to what it is given. Not thread safe.
class Claims {
 public:
  Claims(const Evidence& evidence, const Frames& frames, const GroupOptions& options)
      : evidence_(evidence), frames_(frames), options_(options) {}

  // Claims on two frames, from the hypotheses of the pairs between them: the most probable first;
  // none that free space or a person contradicts.
  std::vector<Claim> Between(uint32_t x, const std::vector<const OpenPair*>& pairs) const;

  // The way round by a claim and back by another of its members.
  std::vector<Step> StepsBack(const Link& link, const Hypothesis& by) const;
  // The way round three frames by claims on x ~ y, y ~ z and x ~ z.
  std::vector<Step> StepsRound(const Link& xy, const Link& yz, const Link& xz) const;
  // A quick look: false where that way cannot close.
  bool MayClose(const Link& xy, const Link& yz, const Link& xz) const;
  // The way by the hypothesis and back by the joints of its frame.
  std::vector<Step> StepsBack(const Hypothesis& hypothesis) const;

 private:
  Link MakeLink(const Hypothesis& hypothesis, uint32_t first) const;
  double MostDegrees() const;  // The most that any way round may leave.
  std::vector<Step> StepsBetween(const Link& p, const Link& q) const;
  bool Agree(const Link& p, const Link& q) const;
  bool IsContradicted(const Link& link, const std::vector<const OpenPair*>& pairs) const;
  Claim MakeClaim(const std::vector<Link>& links, size_t center) const;

  const Evidence& evidence_;
  const Frames& frames_;
  const GroupOptions options_;
};

}  // namespace isthmus::match_graph
