#include "server/matching/loops/loop_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/matching/loops/limits.h"
#include "server/matching/loops/loop_confidence.h"
#include "server/matching/loops/loop_decision.h"
#include "server/matching/pairs/candidate_search.h"
#include "server/matching/pairs/limits.h"
#include "server/matching/pairs/submap_alignment.h"
#include "server/matching/search/limits.h"
#include "server/pose_graph/limits.h"

namespace isthmus::matching {
namespace {

using Submaps = std::vector<std::shared_ptr<const Submap>>;

struct Windows {
  size_t first_old = 0, last_old = 0, first_new = 0;
};

// Runs of the way, so that odometry holds each together. Nothing when they would meet.
std::optional<Windows> ChooseWindows(const LoopScene& scene, size_t place,
                                     const LoopOptions& options) {
  const std::vector<double>& path_lengths = scene.path_lengths;
  const double gap = kWindowGapShare * options.min_path_length_m;
  const auto near = [&](size_t i, size_t j) {
    return std::abs(path_lengths[i] - path_lengths[j]) < 1.5 * options.min_path_length_m;
  };
  const size_t last = scene.submaps.size() - 1;
  Windows windows{place, place, last};
  while (windows.first_new > 0 && last - windows.first_new + 1 < kNewestSubmaps &&
         near(windows.first_new - 1, last) &&
         path_lengths[windows.first_new - 1] - path_lengths[place] > gap) {
    --windows.first_new;
  }
  while (windows.first_old > 0 && place - windows.first_old < kBesideSubmaps &&
         near(windows.first_old - 1, place)) {
    --windows.first_old;
  }
  while (windows.last_old - place < kBesideSubmaps && near(windows.last_old + 1, place) &&
         path_lengths[windows.first_new] - path_lengths[windows.last_old + 1] > gap) {
    ++windows.last_old;
  }
  if (path_lengths[windows.first_new] - path_lengths[windows.last_old] <= gap) return std::nullopt;
  return windows;
}

class Search {
 public:
  Search(const LoopScene& scene, const LoopCandidate& candidate, const Windows& windows,
         const LoopOptions& options, LoopSubmaps* submaps)
      : scene_(scene),
        candidate_(candidate),
        windows_(windows),
        options_(options),
        submaps_(submaps),
        old_(submaps->Window(SubmapsBetween(windows.first_old, windows.last_old + 1))),
        fresh_(submaps->Window(SubmapsBetween(windows.first_new, scene.submaps.size()))),
        outdoors_(IsOutdoors(old_) && IsOutdoors(fresh_)),
        far_(candidate.reach_m > Capture() ||
             candidate.reach_rad > kCaptureM / pose_graph::kLeverM),
        may_have_rivals_(candidate.reach_m > kRivalReach * Capture()) {}

  std::optional<LoopClosure> Run(bool thorough) {
    if (fresh_.submaps().back()->surface().empty()) return std::nullopt;
    std::vector<Hypothesis> found = Align(Guesses());
    if (!may_have_rivals_) {
      if (auto closed = TakeHypotheses(found)) return closed;
    }
    if (!far_ || !thorough) return std::nullopt;
    CandidateSearch search(old_, fresh_);
    std::vector<StageTime> stages;
    search.ByBirdsEye(&found, &stages, [this](const Pose& T_a_b) {
      return IsPossible(T_a_b, kGuessErrorM, kGuessErrorRad);
    });
    return TakeHypotheses(std::move(found));
  }

 private:
  Submaps SubmapsBetween(size_t begin, size_t end) const {
    const auto at = [&](size_t i) {
      return scene_.submaps.begin() + static_cast<std::ptrdiff_t>(i);
    };
    return Submaps(at(begin), at(end));
  }

  const Submap& place() const { return *scene_.submaps[candidate_.position]; }

  // Between the odom frames that the two windows carry: the same one but for the drift.
  Pose ToOdom(const Pose& T_new_old) const {
    return place().T_odom_submap * T_new_old.Inverse() * scene_.newest()->T_odom_submap.Inverse();
  }

  bool IsPossible(const Pose& T_a_b, double slack_m, double slack_rad) const {
    const Pose T_new_old =
        (place().T_odom_submap.Inverse() * T_a_b * scene_.newest()->T_odom_submap).Inverse();
    const double chi2 = scene_.known[candidate_.position].Chi2(
        T_new_old, MiddleOf(*scene_.newest()), slack_m, slack_rad);
    return chi2 < options_.drift_sigmas * options_.drift_sigmas;
  }

  // Each by an alignment of the newest submap that settles, which is much cheaper than one of the
  // whole windows.
  std::vector<Hypothesis> Align(const std::vector<Candidate>& guesses) const {
    const double gate = std::clamp(candidate_.reach_m, kKnownGateM, Capture());
    std::vector<Hypothesis> aligned;
    for (const Candidate& guess : guesses) {
      const PreparedSubmap& b = *fresh_.submaps().back();
      const Pose T_a_submap = guess.T_a_b * b.submap().T_odom_submap;
      const PreparedSubmap& a = Nearest(T_a_submap * MiddleOf(b.submap()));
      const Pose& T_odom_a = a.submap().T_odom_submap;
      const auto found = AlignSubmaps(a, b, T_odom_a.Inverse() * T_a_submap, gate);
      if (!found) continue;
      Hypothesis h;
      h.source = guess.source;
      h.outdoors = outdoors_;
      h.T_a_b = T_odom_a * found->T_a_b * b.submap().T_odom_submap.Inverse();
      h.converged = true;
      const Eigen::Vector3d middle = b.submap().T_odom_submap.translation();
      const bool known = std::any_of(aligned.begin(), aligned.end(), [&](const Hypothesis& other) {
        return IsSameAlignment(h.T_a_b, other.T_a_b, middle);
      });
      if (known) continue;
      h.free_space =
          ScoreFreeSpace(old_.free_space(), fresh_.free_space(),
                         MapPoses::Rigid(old_.session_map(), fresh_.session_map(), h.T_a_b),
                         FreeSpaceOptions::For(outdoors_));
      aligned.push_back(std::move(h));
    }
    return aligned;
  }

  // The nearest submap of the old window, by the ways.
  const PreparedSubmap& Nearest(const Eigen::Vector3d& middle) const {
    const auto apart = [&](const PreparedSubmap& old) {
      return (old.submap().T_odom_submap * MiddleOf(old.submap()) - middle).squaredNorm();
    };
    return **std::min_element(old_.submaps().begin(), old_.submaps().end(),
                              [&](const auto& x, const auto& y) { return apart(*x) < apart(*y); });
  }

  std::optional<LoopClosure> TakeHypotheses(std::vector<Hypothesis> found) const {
    std::erase_if(found, [&](const Hypothesis& h) {
      return !IsPossible(h.T_a_b, kGuessErrorM, kGuessErrorRad);
    });
    const std::vector<Hypothesis> verified = Verify(std::move(found));
    const Hypothesis* chosen = ChooseLoop(verified, options_);
    if (!chosen || !IsPossible(chosen->T_a_b, kWindowErrorM, kWindowErrorRad)) return std::nullopt;
    return Close(*chosen);
  }

  double Capture() const { return outdoors_ ? 2 * kCaptureM : kCaptureM; }

  std::vector<Candidate> Guesses() {
    std::vector<Candidate> guesses = {{ToOdom(candidate_.T_new_old), 0, GuessSource::kOdometry}};
    const Pose placed =
        scene_.T_map_submap.back().Inverse() * scene_.T_map_submap[candidate_.position];
    guesses.push_back({ToOdom(placed), 0, GuessSource::kOdometry});
    if (!far_) return guesses;
    std::vector<Place> old, fresh;
    for (size_t i = windows_.first_old; i < scene_.submaps.size(); ++i) {
      if (i > windows_.last_old && i < windows_.first_new) continue;
      for (Place place : submaps_->Places(scene_.submaps[i])) {
        place.T_odom_place = scene_.submaps[i]->T_odom_submap * place.T_odom_place;
        (i <= windows_.last_old ? old : fresh).push_back(std::move(place));
      }
    }
    for (Candidate& place : SearchPlaces(old, fresh, kWindowPlaceGuesses)) {
      guesses.push_back(std::move(place));
    }
    std::erase_if(guesses, [&](const Candidate& c) {
      return !IsPossible(c.T_a_b, kGuessErrorM, kGuessErrorRad);
    });
    return guesses;
  }

  double MaxFreeSpace() const {
    return outdoors_ ? options_.max_free_space_outdoors : options_.max_free_space;
  }

  // The best refined jointly, best first.
  std::vector<Hypothesis> Verify(std::vector<Hypothesis> found) const {
    const double limit = MaxFreeSpace();
    for (Hypothesis& h : found) h.max_free_space = std::min(kLoopLeniency * limit, 0.5);
    RankHypotheses(&found);
    std::vector<Hypothesis> judged;
    for (const Hypothesis& rigid : found) {
      if (judged.size() == kMaxJointLoops) break;
      if (!judged.empty() && rigid.Support() < kMinRivalShare * found.front().Support()) break;
      Hypothesis& h = judged.emplace_back(rigid);
      h.max_free_space = limit;
      h.shared_center = place().T_odom_submap * MiddleOf(place());
      MeasureJointly(old_, fresh_, &h);
      const bool known =
          std::any_of(judged.begin(), judged.end() - 1,
                      [&](const Hypothesis& other) { return IsSamePlace(h.joint, other.joint); });
      if (known) judged.pop_back();
    }
    RankHypotheses(&judged);
    return judged;
  }

  std::optional<LoopClosure> Close(const Hypothesis& h) const {
    LoopClosure closure;
    closure.session = scene_.newest()->id.session;
    closure.overlap = h.overlap;
    closure.residual_m = h.residual_m;
    closure.free_space = h.free_space.violation();
    closure.comparisons = h.free_space.comparisons();
    closure.source = h.source;
    closure.edges = ChooseEdges(h.joint.edges);
    if (closure.edges.empty()) return std::nullopt;
    closure.submap_a = closure.edges.front().submap_a;
    closure.submap_b = closure.edges.front().submap_b;
    closure.T_a_b = closure.edges.front().T_a_b;
    DescribeLoop(MaxFreeSpace(), CameBack(closure), &closure);
    return closure;
  }

  // Edges for pairs that no loop joins yet: the newest submap's first, then one of each of the
  // others, until there are enough.
  std::vector<SubmapEdge> ChooseEdges(const std::vector<SubmapEdge>& all) const {
    std::vector<std::pair<int, SubmapEdge>> ranked;
    std::vector<int> of(fresh_.submaps().size(), 0);
    for (const SubmapEdge& edge : all) {
      SubmapEdge named = edge;
      named.submap_a = old_.submaps()[edge.submap_a]->submap().id.index;
      named.submap_b = fresh_.submaps()[edge.submap_b]->submap().id.index;
      if (scene_.joined.count({named.submap_a, named.submap_b}) > 0) continue;
      ranked.emplace_back(of[edge.submap_b]++, named);
    }
    std::stable_sort(ranked.begin(), ranked.end(), [](const auto& x, const auto& y) {
      return x.first != y.first ? x.first < y.first : x.second.submap_b > y.second.submap_b;
    });
    if (ranked.size() > options_.max_edges) ranked.resize(std::max<size_t>(options_.max_edges, 1));
    std::vector<SubmapEdge> chosen;
    chosen.reserve(ranked.size());
    for (auto& [rank, edge] : ranked) chosen.push_back(edge);
    return chosen;
  }

  const LoopScene& scene_;
  const LoopCandidate& candidate_;
  const Windows windows_;
  const LoopOptions& options_;
  LoopSubmaps* const submaps_;
  const PreparedMap old_, fresh_;
  const bool outdoors_;
  const bool far_;              // Odometry may have strayed farther than an alignment captures.
  const bool may_have_rivals_;  // And so far that another place like it may be meant.
};

}  // namespace

std::optional<LoopClosure> CloseLoop(const LoopScene& scene, const LoopCandidate& candidate,
                                     const LoopOptions& options, bool thorough,
                                     LoopSubmaps* submaps) {
  const std::optional<Windows> windows = ChooseWindows(scene, candidate.position, options);
  if (!windows) return std::nullopt;
  return Search(scene, candidate, *windows, options, submaps).Run(thorough);
}

}  // namespace isthmus::matching
