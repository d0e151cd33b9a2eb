// The matcher of two sessions' maps: search, refine, verify, decide.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/map/anchor.h"
#include "core/map/match.h"
#include "core/map/submap.h"
#include "server/matching/pairs/anchor_prior.h"
#include "server/matching/pairs/candidate_search.h"
#include "server/matching/pairs/hypothesis.h"
#include "server/matching/pairs/matcher_options.h"
#include "server/matching/prepared/prepared_map.h"

namespace isthmus::matching {

// All that is kept of a pair from one update to the next. Value type.
struct PairMemory {
  SessionMap a, b;                     // As of the last update. Outlines will do.
  std::vector<Hypothesis> hypotheses;  // Best first.
  bool accepted = false;
  bool lacks_ground = false;           // All that was lacking is more ground seen by both.
  uint64_t searched = 0;               // Submaps of both at the last search, ...
  uint64_t come = 0;                   // ... and those that came since, retired or not.
  std::optional<Pose> searched_guess;  // T_a_b at which anchors had put the maps when searched.
};

// One pair of sessions. With what it remembers, a map that has grown costs what is new in it, and
// only now and then a search of the whole. Not thread safe; starts no threads beyond what PCL's
// OpenMP does.
class PairMatcher {
 public:
  // Goes on from `memory`, that of an earlier matcher of the pair.
  explicit PairMatcher(const MatcherOptions& options, PairMemory memory = {})
      : options_(options), memory_(std::move(memory)) {}

  // The memory for the next matcher of the pair. This one is spent afterwards.
  PairMemory TakeMemory() { return std::move(memory_); }

  // The match of the pair (a, b), a.session < b.session; every field of Match is filled but
  // computed_ns and the cycle's. Never fails: what cannot be decided is NOT_YET with a reason.
  // Deterministic. The stage "prepare" is what making the maps took, though not in this call.
  //
  // Searches both whole maps at the first call, when so many submaps came since the last search as
  // a quarter of what there was (when accepted: when the maps have doubled), when a new submap
  // looks and lies like a place of the other map, or when they are not what they were with more
  // submaps at their ends; and whenever `search` says so (with MatcherOptions::first_look it looks
  // first whether it is worth it). Otherwise the hypotheses kept are refined
  // and verified with the new submaps. Submaps that were retired cost nothing: what was found with
  // them stays, but for their edges.
  //
  // Where loops have moved submaps an accepted pair is judged again from where it lay, and searched
  // only if it does not hold; any other pair is searched. T_a_b is between the odom frames as the
  // odometry has them, such as suits the submaps where the maps meet (its edges): nobody outside
  // sees shapes. Edges name submaps by Submap::id.index.
  //
  // Reasons: OK (ACCEPTED); AMBIGUOUS, POSSIBLE_TWIN (AMBIGUOUS); FREE_SPACE (REJECTED, NOT_YET);
  // FEW_COMPARISONS, LOW_OVERLAP, LOOSE, TOO_SMALL, NO_CANDIDATE, DEGENERATE, NOT_CONVERGED,
  // STRAINED (NOT_YET).
  Match Update(const PreparedMap& a, const PreparedMap& b, bool search = false);

  // The hypothesis of the last Update's match, if that was accepted, or would have been before:
  // where drift has one end of the maps double, free space contradicts it. Else null.
  const Hypothesis* joined() const;

  // All of the last Update, the most probable first.
  const std::vector<Hypothesis>& hypotheses() const { return memory_.hypotheses; }

  // Bends the maps of that hypothesis so that they meet where `meetings` say, too, and judges the
  // match by that. False, with the match as it was, where it would not be accepted like that.
  bool Tie(const PreparedMap& a, const PreparedMap& b, Meetings meetings, Match* match);

  // The anchors of submaps of either map, in order of their ids. The match is less sure of places
  // that anchors do not allow, and surer of places where they put the maps. Holds for all updates
  // from here on.
  void SetAnchors(std::vector<Anchor> anchors) { anchors_ = std::move(anchors); }

  // A match that is known from before, to be tried in the next search beside all others.
  void Suggest(const Match& match) { known_.push_back(match); }

 private:
  // From positions in the maps at hand to the submaps' indices.
  void NameSubmaps(std::vector<SubmapEdge>* edges) const;
  enum class Maps { kOthers, kGrown, kMoved };
  // Forgets submaps that were retired since the last call, and takes the hypotheses along with
  // those that have moved.
  Maps FollowMaps(const SessionMap& a, const SessionMap& b);
  // Names T_a_b and edges as all outside know them, and remembers the maps.
  void Finish(const PreparedMap& a, const PreparedMap& b, Match* match);
  bool MustSearch(const PreparedMap& a, const PreparedMap& b) const;
  void SearchMatch(const PreparedMap& a, const PreparedMap& b, Match* match);
  void SearchInFull(const PreparedMap& a, const PreparedMap& b, CandidateSearch* search,
                    Match* match);
  void ExtendMatch(const PreparedMap& a, const PreparedMap& b, Match* match);
  // All hypotheses anew, from where they are.
  void JudgeAgain(const PreparedMap& a, const PreparedMap& b, Match* match);
  // Refines and measures one that is the last of the hypotheses; drops it where it is another's
  // place by then.
  void JudgeLast(const PreparedMap& a, const PreparedMap& b);
  void SuggestKnown(const PreparedMap& a, const PreparedMap& b);
  // Suggests what new submaps look like in the other map, unless a first look refutes it or it is
  // known; true when there was something.
  bool SuggestPlaces(const PreparedMap& a, const PreparedMap& b);
  // True when anchors put the maps where nothing was found and they were not looked for.
  bool MustSearchAtAnchors(const PreparedMap& a, const PreparedMap& b) const;
  // AnchorPrior::LogOdds of a rigid alignment.
  double AtAnchors(const PreparedMap& a, const PreparedMap& b, const Pose& T_a_b) const;
  // The rigid hypotheses to be refined jointly: ones that anchors refute come last.
  std::vector<Hypothesis> SelectPromising(const PreparedMap& a, const PreparedMap& b,
                                          std::vector<Hypothesis>* found) const;
  void WeighAnchors(const PreparedMap& a, const PreparedMap& b, Hypothesis* h) const;
  // Ranks the hypotheses, with what anchors say of them, and fills the match.
  void Decide(const PreparedMap& a, const PreparedMap& b, Match* match);

  const MatcherOptions options_;
  std::vector<Match> known_;
  std::vector<Candidate> suggested_;
  std::vector<Anchor> anchors_;
  AnchorPrior prior_;          // By anchors_, for the maps at hand.
  bool was_accepted_ = false;  // Before the last update.
  PairMemory memory_;
};

}  // namespace isthmus::matching
