#include "server/matching/pairs/candidate_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/paper.h"
#include "core/stopwatch.h"
#include "server/matching/pairs/limits.h"
#include "server/matching/paper/feature_chain.h"
#include "server/matching/paper/feature_chain_options.h"
#include "server/matching/prepared/shared_area.h"
#include "server/matching/registration/limits.h"
#include "server/matching/search/birds_eye.h"
#include "server/matching/search/limits.h"
#include "server/matching/search/structure_search.h"

namespace isthmus::matching {
namespace {

bool HasViews(const PreparedMap& map) {
  return std::any_of(map.submaps().begin(), map.submaps().end(),
                     [](const auto& submap) { return !submap->views().empty(); });
}

// Puts those of the largest number first.
template <typename T>
void Rank(std::vector<std::pair<double, T>>* numbered) {
  std::stable_sort(numbered->begin(), numbered->end(),
                   [](const auto& x, const auto& y) { return x.first > y.first; });
}

}  // namespace

CandidateSearch::CandidateSearch(const PreparedMap& a, const PreparedMap& b, std::stop_token stop)
    : a_(a), b_(b), scale_(PairScale(a.whole().walls, b.whole().walls)), stop_(std::move(stop)) {
  refine_options_ = a.whole().refine_options;
  refine_options_.voxel_m = std::max(refine_options_.voxel_m, b.whole().refine_options.voxel_m);
  if (scale_.outdoors) refine_options_.coarse_distance_m *= 1.5;
  middle_b_ = b.whole().walls.MeanSensor();
  walls_b_ = &b.whole().walls;
}

std::vector<Candidate> CandidateSearch::MostOverlapping(const std::vector<Candidate>& candidates,
                                                        size_t limit) const {
  std::vector<std::pair<double, const Candidate*>> looked;
  looked.reserve(candidates.size());
  for (const Candidate& candidate : candidates) {
    looked.emplace_back(
        CoarseOverlap(a_.whole().refinable, b_.whole().refinable, candidate.T_a_b, kFirstLookM),
        &candidate);
  }
  Rank(&looked);
  std::vector<Candidate> best;
  for (size_t i = 0; i < std::min(limit, looked.size()); ++i) best.push_back(*looked[i].second);
  return best;
}

bool CandidateSearch::IsAmong(const std::vector<Candidate>& known,
                              const Candidate& candidate) const {
  return std::any_of(known.begin(), known.end(), [&](const Candidate& other) {
    return IsSameAlignment(candidate.T_a_b, other.T_a_b, middle_b_);
  });
}

std::vector<Candidate> CandidateSearch::OneOfEachPlace(
    const std::vector<Candidate>& guesses) const {
  const RefinableMap &a = a_.whole().refinable, &b = b_.whole().refinable;
  std::vector<std::pair<double, Candidate>> aligned;
  for (Candidate guess : guesses) {
    if (stop_.stop_requested()) return {};
    guess.T_a_b = AlignCoarsely(a, b, guess.T_a_b, refine_options_);
    if (!guess.T_a_b.IsFinite() || Tilt(guess.T_a_b) > kMaxTiltRad) continue;
    aligned.emplace_back(CoarseOverlap(a, b, guess.T_a_b, kOnSurfaceM), guess);
  }
  Rank(&aligned);
  std::vector<Candidate> places;
  for (const auto& ranked : aligned) {
    if (!IsAmong(places, ranked.second)) places.push_back(ranked.second);
  }
  return places;
}

bool CandidateSearch::LooksPromising(std::vector<StageTime>* stages) {
  if (!HasViews(a_) || !HasViews(b_)) return true;
  std::vector<Hypothesis> found;
  for (const std::vector<Candidate>& guesses :
       {OnStoreys(SearchStructure(a_.whole().walls, *walls_b_, stop_, stages)),
        SearchPlaces(a_.places(), b_.places(), kFirstPlaces)}) {
    TakeCandidates(MostOverlapping(guesses, kFirstLooks), &found, stages);
  }
  return std::any_of(found.begin(), found.end(), [](const Hypothesis& h) {
    const double tight = TightOverlap(1, h.residual_m);
    return h.free_space.Support(kRefutedShare) * tight >= kLeastFirstSupport ||
           (static_cast<double>(h.free_space.agree) * tight >= kLeastFirstAgreements &&
            h.free_space.violation() <= kHardlyContradicted);
  });
}

void CandidateSearch::ByBirdsEye(std::vector<Hypothesis>* found, std::vector<StageTime>* stages,
                                 const Possible& possible) {
  BirdsEyeOptions options;
  options.stop = stop_;
  if (possible) options.candidates *= 2;  // Many of them may lie elsewhere.
  std::vector<Candidate> candidates = SearchBirdsEye(a_.whole().walls, *walls_b_, options, stages);
  if (possible) std::erase_if(candidates, [&](const Candidate& c) { return !possible(c.T_a_b); });
  std::erase_if(candidates, [least = candidates.empty() ? 0 : candidates[0].score](
                                const Candidate& c) { return c.score < kMinRivalShare * least; });
  TakeCandidates(OnStoreys(candidates), found, stages);
}

std::vector<Candidate> CandidateSearch::OnStoreys(const std::vector<Candidate>& candidates) const {
  std::vector<double> heights;
  for (const float at_a : a_.whole().walls.storeys()) {
    for (const float at_b : walls_b_->storeys()) {
      const double height = at_a - at_b;
      const bool known = std::any_of(heights.begin(), heights.end(), [&](double other) {
        return std::abs(other - height) < kMinStoreyM / 2;
      });
      if (!known && heights.size() < kMaxStoreyHeights) heights.push_back(height);
    }
  }
  if (heights.size() < 2) return candidates;
  const Eigen::Vector3d up = a_.T_level_odom().rotation().inverse() * Eigen::Vector3d::UnitZ();
  std::vector<Candidate> on_storeys;
  for (const Candidate& candidate : candidates) {
    std::vector<std::pair<double, Candidate>> tried;
    for (const double height : heights) {
      Candidate moved = candidate;
      moved.T_a_b = Pose(Eigen::Vector3d(height * up)) * candidate.T_a_b;
      tried.emplace_back(
          CoarseOverlap(a_.whole().refinable, b_.whole().refinable, moved.T_a_b, kFirstLookM),
          moved);
    }
    Rank(&tried);
    for (size_t i = 0; i < std::min(kStoreysTried, tried.size()); ++i) {
      if (tried[i].first < kMinStoreyOverlap * tried[0].first) break;
      on_storeys.push_back(tried[i].second);
    }
  }
  return on_storeys;
}

void CandidateSearch::ByStructure(std::vector<Hypothesis>* found, std::vector<StageTime>* stages) {
  TakeCandidates(OnStoreys(SearchStructure(a_.whole().walls, *walls_b_, stop_, stages)), found,
                 stages);
}

void CandidateSearch::ByPlaces(std::vector<Hypothesis>* found, std::vector<StageTime>* stages) {
  const Stopwatch watch;
  const std::vector<Candidate> candidates = SearchPlaces(a_.places(), b_.places(), kPlaceGuesses);
  stages->push_back({"places", watch.Ms()});
  TakeCandidates(candidates, found, stages);
}

void CandidateSearch::ByRepeats(std::vector<Hypothesis>* found, std::vector<StageTime>* stages) {
  std::vector<const Hypothesis*> best;
  for (const Hypothesis& h : *found) best.push_back(&h);
  std::stable_sort(best.begin(), best.end(), [](const Hypothesis* x, const Hypothesis* y) {
    return x->Agreement() > y->Agreement();
  });
  const auto overlap = [&](const Pose& T_a_b) {
    return CoarseOverlap(a_.whole().refinable, b_.whole().refinable, T_a_b, kFirstLookM);
  };
  std::vector<Candidate> moved;
  for (size_t k = 0; k < std::min(best.size(), kMaxRepeated); ++k) {
    const Hypothesis* h = best[k];
    const double least = kMinRepeatedOverlap * overlap(h->T_a_b);
    const auto take = [&](const Pose& T_a_b) {
      if (overlap(T_a_b) >= least) moved.push_back({T_a_b, 0, GuessSource::kRepeats});
    };
    for (const Pose& T_a_b : MovedByRepeats(a_, b_, h->T_a_b)) take(T_a_b);
  }
  TakeCandidates(moved, found, stages);
}

void CandidateSearch::ByAnchors(const Pose& guess_T_a_b, double sigma_m,
                                std::vector<Hypothesis>* found, std::vector<StageTime>* stages) {
  const Stopwatch watch;
  const Pose T_level_a = a_.T_level_odom();
  const Pose to_middle((T_level_a * guess_T_a_b) * middle_b_);  // Turns are about the middle of b.
  const int reach =
      static_cast<int>(std::ceil(std::min(2 * sigma_m, kAnchorReachM) / kAnchorStepM));
  std::vector<std::pair<double, Candidate>> looked;
  const auto look = [&](int x, int y, int turn) {
    const Pose moved =
        Pose::FromXyzRpy(x * kAnchorStepM, y * kAnchorStepM, 0, 0, 0, turn * kAnchorTurnRad);
    const Pose T_a_b =
        T_level_a.Inverse() * to_middle * moved * to_middle.Inverse() * T_level_a * guess_T_a_b;
    looked.emplace_back(
        CoarseOverlap(a_.whole().refinable, b_.whole().refinable, T_a_b, kFirstLookM),
        Candidate{T_a_b, 0, GuessSource::kAnchors});
  };
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      for (int turn = -kAnchorTurns; turn <= kAnchorTurns; ++turn) look(x, y, turn);
    }
  }
  Rank(&looked);
  std::vector<Candidate> best = {{guess_T_a_b, 0, GuessSource::kAnchors}};
  for (const auto& ranked : looked) {
    if (!IsAmong(best, ranked.second)) best.push_back(ranked.second);
    if (best.size() == kAnchorGuesses) break;
  }
  stages->push_back({"anchors", watch.Ms()});
  TakeCandidates(OnStoreys(best), found, stages);
}

bool CandidateSearch::TurnOver() {
  if (!a_.may_be_upside_down() && !b_.may_be_upside_down()) return false;
  walls_b_ = &b_.turned_over();
  return true;
}

void CandidateSearch::ByFeatures(std::vector<Hypothesis>* found, std::vector<StageTime>* stages) {
  if (stop_.stop_requested()) return;
  if constexpr (kHasPaper) {  // Else nobody defines SearchByFeatures.
    FeatureChainOptions chain;
    const auto askew = [](const PreparedMap& map) {
      return map.T_level_odom().rotation().angularDistance(Eigen::Quaterniond::Identity());
    };
    chain.ransac.max_tilt_rad = std::min(M_PI, askew(a_) + askew(b_) + kMaxTiltRad);
    TakeCandidates(SearchByFeatures(a_.session_map(), b_.session_map(), chain, stages), found,
                   stages);
  }
}

void CandidateSearch::TakeCandidates(const std::vector<Candidate>& candidates,
                                     std::vector<Hypothesis>* found,
                                     std::vector<StageTime>* stages) {
  Stopwatch watch;
  candidates_ += static_cast<uint32_t>(candidates.size());
  std::vector<Hypothesis> fresh;
  for (const Candidate& candidate : OneOfEachPlace(candidates)) {
    if (stop_.stop_requested()) return;
    const Refinement refined =
        AlignFinely(a_.whole().refinable, b_.whole().refinable, candidate.T_a_b, refine_options_);
    if (!refined.T_a_b.IsFinite() || Tilt(refined.T_a_b) > kMaxTiltRad) continue;
    Hypothesis h;
    h.source = candidate.source;
    h.outdoors = scale_.outdoors;
    h.T_a_b = refined.T_a_b;
    h.converged = refined.converged;
    h.overlap = refined.overlap;
    h.inliers = refined.inliers;
    h.residual_m = refined.residual_m;
    // The better of two at one place stays: the refinement of a bad guess may have stopped short.
    const auto is_same = [&](const Hypothesis& other) {
      return IsSameAlignment(h.T_a_b, other.T_a_b, middle_b_);
    };
    const auto is_worse = [&](const Hypothesis& other) {
      return is_same(other) && kBetterAgreement * other.Agreement() < h.Agreement();
    };
    std::erase_if(*found, is_worse);
    std::erase_if(fresh, is_worse);
    const bool known = std::any_of(found->begin(), found->end(), is_same) ||
                       std::any_of(fresh.begin(), fresh.end(), is_same);
    if (!known) fresh.push_back(std::move(h));
  }
  stages->push_back({"refine", watch.Lap()});
  for (Hypothesis& h : fresh) {
    if (stop_.stop_requested()) return;
    h.free_space = ScoreFreeSpace(a_.free_space(), b_.free_space(),
                                  MapPoses::Rigid(a_.session_map(), b_.session_map(), h.T_a_b),
                                  FreeSpaceOptions::For(scale_.outdoors));
    found->push_back(std::move(h));
  }
  stages->push_back({"free_space", watch.Lap()});
}

// Cosine of the angle between the two maps' verticals.
double CandidateSearch::UpCosine(const Pose& T_a_b) const {
  const Eigen::Vector3d up_b = b_.T_level_odom().rotation().inverse() * Eigen::Vector3d::UnitZ();
  return ((a_.T_level_odom() * T_a_b).rotation() * up_b).z();
}

// The angle between the verticals, with either end up if that is in doubt.
double CandidateSearch::Tilt(const Pose& T_a_b) const {
  const bool doubtful = a_.may_be_upside_down() || b_.may_be_upside_down();
  const double cosine = UpCosine(T_a_b);
  return std::acos(std::clamp(doubtful ? std::abs(cosine) : cosine, -1.0, 1.0));
}

void CandidateSearch::MeasureRepetition(Hypothesis* h) const {
  h->repetition = std::max(a_.self_similarity().degree(), b_.self_similarity().degree());
}

void CandidateSearch::MeasureShared(Hypothesis* h) {
  const auto cells_of = [&](const WallMap& walls, BirdsEyeCells* cells) -> const BirdsEyeCells& {
    if (cells->cell_m == 0) {
      const double cell =
          CellThatFits(a_.whole().walls, b_.whole().walls, scale_, 2 * scale_.cell_m);
      *cells = MakeBirdsEyeCells(walls, scale_, cell);
    }
    return *cells;
  };
  const bool turned = UpCosine(h->T_a_b) < 0;
  const WallMap& walls_b = turned ? b_.turned_over() : b_.whole().walls;
  const Pose T_level_level = a_.T_level_odom() * h->T_a_b * walls_b.T_level_odom().Inverse();
  const SharedArea shared =
      MeasureSharedArea(cells_of(a_.whole().walls, &a_cells_),
                        cells_of(walls_b, turned ? &b_turned_cells_ : &b_cells_), T_level_level);
  h->shared_area_m2 = shared.area_m2;
  h->shared_share = shared.share;
  h->upside_down = (h->T_a_b.rotation() * Eigen::Vector3d::UnitZ()).z() < 0;
  h->can_be_refuted = HasViews(a_) && HasViews(b_);
  // At the height of b's sensor, wherever the origins of the odom frames are.
  const double height = (a_.T_level_odom() * h->T_a_b * middle_b_).z();
  h->shared_center =
      a_.T_level_odom().Inverse() * Eigen::Vector3d(shared.center.x(), shared.center.y(), height);
}

}  // namespace isthmus::matching
