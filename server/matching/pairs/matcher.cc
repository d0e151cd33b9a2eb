#include "server/matching/pairs/matcher.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/stopwatch.h"
#include "server/matching/pairs/candidate_search.h"
#include "server/matching/pairs/decision.h"
#include "server/matching/pairs/limits.h"
#include "server/matching/pairs/odom_transform.h"
#include "server/matching/pairs/probability.h"
#include "server/matching/pairs/submap_alignment.h"
#include "server/matching/prepared/limits.h"
#include "server/matching/registration/limits.h"

namespace isthmus::matching {
namespace {

// Nothing that was found is likely.
bool IsAtALoss(const Match& match) {
  const bool open = match.state == MatchState::kNotYet || match.state == MatchState::kRejected;
  return open && match.confidence < kLikely;
}

// A guess from how a place looks, by one alignment of submaps and their free space: the refined
// guess, or nothing where the new submaps of `b` contradict it or have too little to say.
std::optional<Pose> LookCloser(const PreparedMap& a, const PreparedMap& b, size_t first_b,
                               const Pose& guess_T_a_b) {
  std::optional<Pose> best;
  FreeSpaceScore best_score;
  for (size_t j = first_b; j < b.submaps().size(); ++j) {
    const Pose& T_odom_b = b.submaps()[j]->submap().T_odom_submap;
    const Eigen::Vector3d middle = guess_T_a_b * (T_odom_b * b.submaps()[j]->center());
    const auto nearest =
        std::min_element(a.submaps().begin(), a.submaps().end(), [&](const auto& x, const auto& y) {
          const auto apart = [&](const PreparedSubmap& s) {
            return (s.submap().T_odom_submap * s.center() - middle).squaredNorm();
          };
          return apart(*x) < apart(*y);
        });
    if (nearest == a.submaps().end()) continue;
    const Pose& T_odom_a = (*nearest)->submap().T_odom_submap;
    const auto aligned = AlignSubmaps(**nearest, *b.submaps()[j],
                                      T_odom_a.Inverse() * guess_T_a_b * T_odom_b, kGuessGateM);
    if (!aligned) continue;
    const Pose T_a_b = T_odom_a * aligned->T_a_b * T_odom_b.Inverse();
    const FreeSpaceScore score = ScoreFreeSpace(
        a.free_space(), b.free_space(), MapPoses::Rigid(a.session_map(), b.session_map(), T_a_b),
        FreeSpaceOptions(), a.submaps().size(), j);
    if (score.violation() > kMaxGuessViolation || score.agree <= best_score.agree) continue;
    best = T_a_b;
    best_score = score;
  }
  return best_score.comparisons() >= kMinGuessComparisons ? best : std::nullopt;
}

}  // namespace

bool PairMatcher::MustSearch(const PreparedMap& a, const PreparedMap& b) const {
  const auto searched = static_cast<double>(memory_.searched);
  const size_t have = a.submaps().size() + b.submaps().size();
  if (memory_.accepted) return static_cast<double>(have) >= kAcceptedGrowth * searched;
  return static_cast<double>(memory_.searched + memory_.come) >= kNewMapGrowth * searched;
}

Match PairMatcher::Update(const PreparedMap& a, const PreparedMap& b, bool search) {
  Match match;
  match.a = a.session_map().session;
  match.b = b.session_map().session;
  match.submaps_a = static_cast<uint32_t>(a.submaps().size());
  match.submaps_b = static_cast<uint32_t>(b.submaps().size());
  const Maps maps = FollowMaps(a.session_map(), b.session_map());
  if (maps == Maps::kOthers) memory_.accepted = false;
  was_accepted_ = memory_.accepted;
  prior_ = AnchorPrior(a, b, anchors_);
  const bool anew = maps == Maps::kOthers || (maps == Maps::kMoved && !memory_.accepted);
  if (search || anew || MustSearch(a, b) ||
      (!memory_.accepted && (MustSearchAtAnchors(a, b) || SuggestPlaces(a, b)))) {
    SearchMatch(a, b, &match);
  } else if (maps == Maps::kGrown) {
    ExtendMatch(a, b, &match);
  } else {
    JudgeAgain(a, b, &match);
    if (match.state != MatchState::kAccepted) SearchMatch(a, b, &match);
  }
  Finish(a, b, &match);
  return match;
}

void PairMatcher::Finish(const PreparedMap& a, const PreparedMap& b, Match* match) {
  if ((a.shape() || b.shape()) && !memory_.hypotheses.empty()) {
    const FramePoses here = FramePoses::AsMatched(a.session_map(), b.session_map());
    const FramePoses odometry = FramePoses::ByOdometry(a, b);
    match->T_a_b = Reframe(here, odometry, match->edges, match->T_a_b);
    for (RivalMatch& rival : match->rivals) {
      rival.T_a_b = Reframe(here, odometry, rival.edges, rival.T_a_b);
    }
  }
  memory_.a = a.session_map();
  memory_.b = b.session_map();
  memory_.accepted = match->state == MatchState::kAccepted;
  memory_.lacks_ground =
      match->reason == MatchReason::kTooSmall || match->reason == MatchReason::kPossibleTwin;
  NameSubmaps(&match->edges);
  for (RivalMatch& rival : match->rivals) NameSubmaps(&rival.edges);
}

const Hypothesis* PairMatcher::joined() const {
  const auto& hypotheses = memory_.hypotheses;
  const bool has_one = !hypotheses.empty() && hypotheses.front().converged;
  return has_one && (memory_.accepted || was_accepted_) ? &hypotheses.front() : nullptr;
}

bool PairMatcher::Tie(const PreparedMap& a, const PreparedMap& b, Meetings meetings, Match* match) {
  Stopwatch watch;
  Hypothesis& best = memory_.hypotheses.front();
  best.meetings = std::move(meetings.memory);
  if (meetings.ties.empty()) return false;
  const std::vector<Hypothesis> before = memory_.hypotheses;
  best.joint.ties.insert(best.joint.ties.end(), meetings.ties.begin(), meetings.ties.end());
  MeasurePair(a, b, &best);
  Match tied = *match;
  Decide(a, b, &tied);
  const double contradicted = memory_.hypotheses.front().free_space.violation();
  if (tied.state != MatchState::kAccepted ||
      contradicted > std::max(before.front().free_space.violation(), meetings.max_free_space)) {
    memory_.hypotheses = before;
    return false;
  }
  *match = std::move(tied);
  match->stages.push_back({"tie", watch.Lap()});
  Finish(a, b, match);
  return true;
}

void PairMatcher::NameSubmaps(std::vector<SubmapEdge>* edges) const {
  for (SubmapEdge& edge : *edges) {
    edge.submap_a = memory_.a.submaps[edge.submap_a]->id.index;
    edge.submap_b = memory_.b.submaps[edge.submap_b]->id.index;
  }
}

bool PairMatcher::SuggestPlaces(const PreparedMap& a, const PreparedMap& b) {
  const PreparedMap* maps[] = {&a, &b};
  const size_t first_new[] = {memory_.a.submaps.size(), memory_.b.submaps.size()};
  bool suggested = false;
  for (const int fresh : {0, 1}) {  // The map whose new submaps are looked up in the other.
    const PreparedMap &grown = *maps[fresh], &other = *maps[1 - fresh];
    const auto begin = static_cast<std::ptrdiff_t>(grown.first_place(first_new[fresh]));
    const std::vector<Place> places(grown.places().begin() + begin, grown.places().end());
    for (const Candidate& place : SearchPlaces(other.places(), places, kNewPlaceGuesses)) {
      std::optional<Pose> T_other_grown = LookCloser(other, grown, first_new[fresh], place.T_a_b);
      if (!T_other_grown) continue;
      const Pose T_a_b = fresh == 1 ? *T_other_grown : T_other_grown->Inverse();
      const Eigen::Vector3d middle = b.submaps().back()->submap().T_odom_submap.translation();
      const bool known =
          std::any_of(memory_.hypotheses.begin(), memory_.hypotheses.end(),
                      [&](const auto& h) { return IsSameAlignment(T_a_b, h.T_a_b, middle); });
      if (known) continue;
      suggested_.push_back({T_a_b, 0, place.source});
      suggested = true;
    }
  }
  return suggested;
}

void PairMatcher::Decide(const PreparedMap& a, const PreparedMap& b, Match* match) {
  for (Hypothesis& h : memory_.hypotheses) {
    h.at_anchors = h.by_anchors = 0;
    if (!prior_.empty()) WeighAnchors(a, b, &h);
  }
  RankByProbability(&memory_.hypotheses);
  DecideState(memory_.hypotheses, options_, match);
}

void PairMatcher::SearchMatch(const PreparedMap& a, const PreparedMap& b, Match* match) {
  CandidateSearch search(a, b, options_.stop);
  match->stages.push_back({"prepare", a.prepare_ms() + b.prepare_ms()});
  for (const Hypothesis& h : memory_.hypotheses) suggested_.push_back({h.T_a_b, 0, h.source});
  SuggestKnown(a, b);
  memory_.searched_guess = prior_.Guess();
  const bool is_new = suggested_.empty() && !memory_.searched_guess;
  if (options_.first_look && is_new && !search.LooksPromising(&match->stages)) {
    memory_.hypotheses.clear();
    Decide(a, b, match);
  } else {
    SearchInFull(a, b, &search, match);
  }
  match->candidates = search.candidates();
  memory_.searched = a.submaps().size() + b.submaps().size();
  memory_.come = 0;
}

void PairMatcher::SearchInFull(const PreparedMap& a, const PreparedMap& b, CandidateSearch* all,
                               Match* match) {
  CandidateSearch& search = *all;
  std::vector<Hypothesis> found;
  std::optional<Hypothesis> held;
  if (memory_.accepted) held = memory_.hypotheses.front();
  const auto judge = [&] {
    Stopwatch watch;
    memory_.hypotheses.clear();
    std::vector<Hypothesis> promising = SelectPromising(a, b, &found);
    // The place that was accepted: no rigid fit leads there where drift has bent the maps.
    if (held) promising.insert(promising.begin(), *held);
    for (const Hypothesis& rigid : promising) {
      if (options_.stop.stop_requested()) break;
      Hypothesis& h = memory_.hypotheses.emplace_back(rigid);
      search.MeasureRepetition(&h);
      search.MeasureShared(&h);
      JudgeLast(a, b);
    }
    match->stages.push_back({"joint", watch.Lap()});
    Decide(a, b, match);
  };
  if (!suggested_.empty()) search.TakeCandidates(suggested_, &found, &match->stages);
  suggested_.clear();
  if (memory_.searched_guess) {
    search.ByAnchors(*memory_.searched_guess, prior_.guess_sigma_m(), &found, &match->stages);
  }
  if (options_.search != SearchMode::kPaper) {
    search.ByBirdsEye(&found, &match->stages);
    if (options_.search == SearchMode::kDefault) {
      search.ByStructure(&found, &match->stages);
      search.ByPlaces(&found, &match->stages);
      search.ByRepeats(&found, &match->stages);
    }
    judge();
    if (options_.search == SearchMode::kDefault && match->state != MatchState::kAccepted &&
        search.TurnOver()) {
      search.ByBirdsEye(&found, &match->stages);
      search.ByStructure(&found, &match->stages);
      judge();
    }
  }
  const bool by_features =
      options_.search == SearchMode::kPaper ||
      (options_.search != SearchMode::kBirdsEye && !search.outdoors() && IsAtALoss(*match));
  if (by_features && !a.submaps().empty() && !b.submaps().empty()) {
    search.ByFeatures(&found, &match->stages);
  }
  if (by_features) judge();
}

void PairMatcher::JudgeLast(const PreparedMap& a, const PreparedMap& b) {
  Hypothesis& h = memory_.hypotheses.back();
  MeasurePair(a, b, &h);
  const bool known =
      std::any_of(memory_.hypotheses.begin(), memory_.hypotheses.end() - 1,
                  [&](const Hypothesis& other) { return IsSamePlace(h.joint, other.joint); });
  if (known) memory_.hypotheses.pop_back();
}

void PairMatcher::ExtendMatch(const PreparedMap& a, const PreparedMap& b, Match* match) {
  Stopwatch watch;
  for (Hypothesis& h : memory_.hypotheses) {
    ExtendJointly(a, b, memory_.a.submaps.size(), memory_.b.submaps.size(), &h);
  }
  // It takes the whole maps, which is dear outdoors: only where nothing else is lacking.
  if (memory_.lacks_ground) {
    CandidateSearch search(a, b, options_.stop);
    for (Hypothesis& h : memory_.hypotheses) search.MeasureShared(&h);
  }
  match->candidates = static_cast<uint32_t>(memory_.hypotheses.size());
  match->stages.push_back({"extend", watch.Lap()});
  Decide(a, b, match);
}

}  // namespace isthmus::matching
