#include "server/matching/loops/loop_finder.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/geometry/near.h"
#include "server/matching/loops/limits.h"
#include "server/matching/loops/loop_search.h"
#include "server/matching/loops/loop_tracking.h"
#include "server/pose_graph/limits.h"

namespace isthmus::matching {
namespace {

bool IsLike(const Pose& T_a_b, const Pose& other_T_a_b) {
  return AreNear(T_a_b, other_T_a_b, kPlacedM, kPlacedM / pose_graph::kLeverM);
}

// Position of the submap of that index, or nothing.
std::optional<size_t> FindPosition(const std::vector<std::shared_ptr<const Submap>>& submaps,
                                   uint32_t index) {
  const auto at = std::lower_bound(
      submaps.begin(), submaps.end(), index,
      [](const auto& submap, uint32_t wanted) { return submap->id.index < wanted; });
  if (at == submaps.end() || (*at)->id.index != index) return std::nullopt;
  return static_cast<size_t>(at - submaps.begin());
}

// Adds the edges of the closure among the submaps given; if `placed`, only edges that hold there.
void AddEdges(const LoopClosure& closure, const LoopQuery& query, bool placed,
              std::vector<LoopEdge>* edges) {
  if (closure.rejected) return;
  for (const SubmapEdge& edge : closure.edges) {
    const auto a = FindPosition(query.submaps, edge.submap_a),
               b = FindPosition(query.submaps, edge.submap_b);
    if (!a || !b || *a == *b) continue;
    const Pose T_placed = query.T_map_submap[*a].Inverse() * query.T_map_submap[*b];
    if (placed && !IsLike(edge.T_a_b, T_placed)) continue;
    edges->push_back({*a, *b, edge.T_a_b, edge.information});
  }
}

// The session as of its k-th submap.
LoopScene SceneOf(const LoopQuery& query, size_t k, const std::vector<double>& path_lengths,
                  const std::vector<LoopClosure>& found, const LoopOptions& options) {
  LoopScene scene;
  const auto end = static_cast<std::ptrdiff_t>(k + 1);
  scene.submaps.assign(query.submaps.begin(), query.submaps.begin() + end);
  scene.T_map_submap.assign(query.T_map_submap.begin(), query.T_map_submap.begin() + end);
  scene.path_lengths.assign(path_lengths.begin(), path_lengths.begin() + end);
  for (const auto* closures : {&query.known, &found}) {
    for (const LoopClosure& closure : *closures) {
      // The loops of the submap before may not have reached the placement yet.
      const bool placed =
          closures == &query.known && k > 0 && closure.submap_b < query.submaps[k - 1]->id.index;
      AddEdges(closure, query, placed, &scene.edges);
      for (const SubmapEdge& edge : closure.edges) {
        scene.joined.emplace(edge.submap_a, edge.submap_b);
      }
    }
  }
  // Steps that were corrected make the way no better known than odometry is taken to be.
  std::erase_if(scene.edges, [&](const LoopEdge& edge) {
    return path_lengths[edge.b] - path_lengths[edge.a] < options.min_path_length_m;
  });
  scene.known = LookBack(scene.submaps, scene.path_lengths, scene.edges, options.drift);
  return scene;
}

bool IsClosed(const LoopScene& scene) {
  return std::any_of(scene.joined.begin(), scene.joined.end(),
                     [&](const auto& pair) { return pair.second == scene.newest()->id.index; });
}

// True if a person rejected a loop that says the same: that these stretches of the way lie on each
// other like this.
bool IsRejected(const LoopClosure& closure, const LoopScene& scene, const LoopQuery& query,
                double path_length_m) {
  const auto a = FindPosition(scene.submaps, closure.submap_a);
  const auto b = FindPosition(scene.submaps, closure.submap_b);
  const auto T_odom = [&](size_t i) { return scene.submaps[i]->T_odom_submap; };
  const auto says_so = [&](const SubmapEdge& edge) {
    const auto i = FindPosition(scene.submaps, edge.submap_a);
    const auto j = FindPosition(scene.submaps, edge.submap_b);
    if (!a || !b || !i || !j) return false;
    const bool near = std::abs(scene.path_lengths[*a] - scene.path_lengths[*i]) < path_length_m &&
                      std::abs(scene.path_lengths[*b] - scene.path_lengths[*j]) < path_length_m;
    const Pose T_a_b =
        T_odom(*a).Inverse() * T_odom(*i) * edge.T_a_b * T_odom(*j).Inverse() * T_odom(*b);
    return near && AreNear(T_a_b, closure.T_a_b, kRejectedM, kRejectedRad);
  };
  return std::any_of(query.known.begin(), query.known.end(), [&](const LoopClosure& known) {
    return known.rejected && std::any_of(known.edges.begin(), known.edges.end(), says_so);
  });
}

}  // namespace

struct LoopFinder::State {
  State(const LoopOptions& loop_options, SubmapSource source, SubmapReader points)
      : options(loop_options),
        submaps(std::move(source), loop_options.prepared_submaps, std::move(points),
                &memory.radii_m) {}

  bool WasInVain(double old_path_length, double new_path_length) const {
    const double patience = kPatienceShare * options.min_path_length_m;
    const auto is_near = [&](const LoopMemory::Failure& failure) {
      return std::abs(failure.old_path_length - old_path_length) < patience &&
             new_path_length - failure.new_path_length < patience;
    };
    return std::any_of(memory.failures.begin(), memory.failures.end(), is_near);
  }

  std::optional<LoopClosure> FindFor(const LoopScene& scene) {
    submaps.Prepared(scene.newest());
    const auto candidates = FindLoopCandidates(scene, options, submaps, kMaxLoopCandidates);
    if (candidates.empty()) return std::nullopt;
    if (auto followed = FollowLoop(scene, candidates, options, &submaps)) return followed;
    size_t searches = 0;
    for (const LoopCandidate& candidate :
         FirstOfEachPass(candidates, scene, options.min_path_length_m)) {
      const double old_path_length = scene.path_lengths[candidate.position],
                   new_path_length = scene.path_lengths.back();
      if (WasInVain(old_path_length, new_path_length)) continue;
      if (++searches > kMaxSearches) break;
      const bool thorough = searches == 1;  // One such search is dear enough.
      if (auto closed = CloseLoop(scene, candidate, options, thorough, &submaps)) return closed;
      memory.failures.push_back({old_path_length, new_path_length});
    }
    std::erase_if(memory.failures, [&](const LoopMemory::Failure& failure) {
      return scene.path_lengths.back() - failure.new_path_length > options.min_path_length_m;
    });
    return std::nullopt;
  }

  const LoopOptions options;
  LoopMemory memory;
  LoopSubmaps submaps;
};

LoopFinder::LoopFinder(const LoopOptions& options, SubmapSource source, SubmapReader points)
    : state_(std::make_unique<State>(options, std::move(source), std::move(points))) {}

LoopFinder::~LoopFinder() = default;

const LoopMemory& LoopFinder::memory() const { return state_->memory; }

void LoopFinder::SetMemory(LoopMemory memory) { state_->memory = std::move(memory); }

std::vector<LoopClosure> LoopFinder::Find(const LoopQuery& query) {
  std::vector<LoopClosure> found;
  if (!state_->options.enabled) return found;
  state_->submaps.KeepOnly(query.submaps);
  const std::vector<double> path_lengths = PathLengths(query.submaps);
  for (size_t k = query.first_new; k < query.submaps.size(); ++k) {
    const LoopScene scene = SceneOf(query, k, path_lengths, found, state_->options);
    // Asked before, perhaps before a restart.
    if (IsClosed(scene)) continue;
    const double path_length_m = kRejectedWays * state_->options.min_path_length_m;
    for (const auto& closure :
         {state_->FindFor(scene), FollowSteps(scene, state_->options, &state_->submaps)}) {
      if (closure && !IsRejected(*closure, scene, query, path_length_m)) found.push_back(*closure);
    }
  }
  return found;
}

}  // namespace isthmus::matching
