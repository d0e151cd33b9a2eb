// The search for claims that are so probable together that they are accepted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "server/match_graph/claims.h"

namespace isthmus::match_graph {

// Claims that are accepted together: one, or three that close (x ~ y, y ~ z, x ~ z).
struct Settlement {
  double probability = 0;
  std::vector<const Claim*> claims;
};

// Keeps references to what it is given. Not thread safe.
class SettlementSearch {
 public:
  SettlementSearch(const Evidence& evidence, const Frames& frames, const Claims& claims,
                   const GroupOptions& options);

  // The most probable settlement, none where nothing is probable enough: of two frames, or, where
  // there is no such thing, of three. Its claims last until the next Forget.
  Settlement Find();
  // Frames were joined: what was found of these is out of date.
  void Forget(const std::set<uint32_t>& frames);

 private:
  using FramePair = std::pair<uint32_t, uint32_t>;

  void FindClaims();
  Settlement FindPair() const;
  Settlement FindTriple();
  Settlement SettleThree(const std::vector<Claim>& xy, const std::vector<Claim>& yz,
                         const std::vector<Claim>& xz);
  std::optional<double> OddsOfWrong(const Claim& xy, const Claim& yz, const Claim& xz);

  const Evidence& evidence_;
  const Frames& frames_;
  const Claims& search_;
  const GroupOptions options_;
  const double least_two_;  // Log odds that the two least certain of three must have together.
  std::map<FramePair, std::vector<Claim>> claims_;
  size_t triples_ = 0;  // Looked at so far.
};

}  // namespace isthmus::match_graph
