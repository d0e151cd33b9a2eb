// The ranking of sessions that may have been at one place by how well their plans fit, so that
// a search, which takes seconds, is spent on the likeliest partners of each session.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "core/ids.h"

namespace isthmus::matching {

struct RankedPair {
  std::pair<SessionId, SessionId> sessions;  // first < second.
  double promise = 0;                        // Greater is likelier; of no other meaning.
};

// The ranked pairs, in their order, of which either session has had fewer than `partners` before.
std::vector<RankedPair> TakePartners(const std::vector<RankedPair>& ranked, size_t partners);

// Scores of pairs (ComparePlans). Not thread safe.
class PlaceIndex {
 public:
  void Put(const SessionId& a, const SessionId& b, double score);
  bool Has(const SessionId& a, const SessionId& b) const;
  // Drops all scores of a session.
  void Forget(const SessionId& session);
  void ForgetIf(const std::function<bool(const SessionId&)>& goes);

  // The pairs that are among the `partners` likeliest of either session, likeliest first; equal
  // ones in order of the ids. A pair is the likelier the more its score stands out among all of
  // both sessions': a map of long straight walls fits everywhere.
  std::vector<RankedPair> Rank(size_t partners) const;

 private:
  // Both ways: by session, then by partner.
  std::map<SessionId, std::map<SessionId, double>> scores_;
};

}  // namespace isthmus::matching
