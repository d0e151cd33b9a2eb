#include "server/matching/matcher.h"

#include <algorithm>
#include <utility>

#include "core/stopwatch.h"
#include "server/matching/candidate_search.h"
#include "server/matching/decision.h"

namespace isthmus::matching {
namespace {

// Maps are searched anew when they have grown by this factor since the last time; what was accepted
// is looked for elsewhere more seldom.
constexpr double kGrowth = 1.25, kGrowthAccepted = 2.0;
// What a joint refinement is spent on: the best by rigid alignment, and what comes near them.
constexpr size_t kMaxJoint = 4;
// A hypothesis with less of the best one's support is out of the question.
constexpr double kMinSupportShare = 0.1;

bool IsUndecided(const Match& match) {
  return match.state == MatchState::kNotYet || match.state == MatchState::kRejected;
}

bool IsBeginning(const SessionMap& before, const SessionMap& map) {
  return before.session == map.session && before.submaps.size() <= map.submaps.size() &&
         std::equal(before.submaps.begin(), before.submaps.end(), map.submaps.begin());
}

}  // namespace

void PairMatcher::Suggest(const Pose& T_a_b, const std::string& source) {
  suggested_.push_back({T_a_b, 0, source});
}

bool PairMatcher::MustSearch(const PreparedMap& a, const PreparedMap& b) const {
  if (searched_ == 0 || !IsBeginning(map_a_, a.session_map()) ||
      !IsBeginning(map_b_, b.session_map())) {
    return true;
  }
  const auto have = static_cast<double>(a.submaps().size() + b.submaps().size());
  return have >= (accepted_ ? kGrowthAccepted : kGrowth) * static_cast<double>(searched_);
}

Match PairMatcher::Update(const PreparedMap& a, const PreparedMap& b, bool search) {
  Match match;
  match.a = a.session_map().session;
  match.b = b.session_map().session;
  match.submaps_a = static_cast<uint32_t>(a.submaps().size());
  match.submaps_b = static_cast<uint32_t>(b.submaps().size());
  if (search || MustSearch(a, b)) {
    Search(a, b, &match);
  } else {
    Extend(a, b, &match);
  }
  map_a_ = a.session_map();
  map_b_ = b.session_map();
  accepted_ = match.state == MatchState::kAccepted;
  return match;
}

void PairMatcher::Search(const PreparedMap& a, const PreparedMap& b, Match* match) {
  CandidateSearch search(a, b);
  match->stages.push_back({"prepare", a.prepare_ms() + b.prepare_ms()});
  for (const Hypothesis& h : hypotheses_) suggested_.push_back({h.T_a_b, 0, h.source});
  std::vector<Hypothesis> found;
  hypotheses_.clear();
  const auto judge = [&] {
    Stopwatch watch;
    for (Hypothesis& h : found) {
      h.max_free_space =
          search.outdoors() ? options_.max_free_space_outdoors : options_.max_free_space;
    }
    RankHypotheses(&found);
    hypotheses_.clear();
    for (const Hypothesis& rigid : found) {
      if (hypotheses_.size() == kMaxJoint) break;
      if (rigid.Support() < kMinSupportShare * found.front().Support()) break;
      Hypothesis& h = hypotheses_.emplace_back(rigid);
      search.MeasureShared(&h);
      MeasureJointly(a, b, &h);
    }
    RankHypotheses(&hypotheses_);
    match->stages.push_back({"joint", watch.Lap()});
    Decide(hypotheses_, options_, match);
  };
  if (!suggested_.empty()) search.Take(suggested_, &found, &match->stages);
  suggested_.clear();
  if (options_.search != "paper") {
    search.ByBirdsEye(&found, &match->stages);
    judge();
  }
  const bool by_features =
      options_.search == "paper" ||
      (options_.search != "birds_eye" && !search.outdoors() && IsUndecided(*match));
  if (by_features && !a.submaps().empty() && !b.submaps().empty()) {
    search.ByFeatures(&found, &match->stages);
  }
  if (by_features) judge();
  match->candidates = search.candidates();
  searched_ = a.submaps().size() + b.submaps().size();
}

void PairMatcher::Extend(const PreparedMap& a, const PreparedMap& b, Match* match) {
  Stopwatch watch;
  for (Hypothesis& h : hypotheses_) {
    ExtendJointly(a, b, map_a_.submaps.size(), map_b_.submaps.size(), &h);
  }
  RankHypotheses(&hypotheses_);
  match->candidates = static_cast<uint32_t>(hypotheses_.size());
  match->stages.push_back({"extend", watch.Lap()});
  Decide(hypotheses_, options_, match);
}

Match MatchPrepared(const PreparedMap& a, const PreparedMap& b, const MatcherOptions& options) {
  return PairMatcher(options).Update(a, b);
}

Match MatchSessions(const SessionMap& a, const SessionMap& b, const MatcherOptions& options) {
  return MatchPrepared(PreparedMap(a), PreparedMap(b), options);
}

}  // namespace isthmus::matching
