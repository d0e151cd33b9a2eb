#include "server/matching/loops/meetings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/geometry/se3.h"
#include "server/matching/loops/joined_way.h"
#include "server/matching/loops/limits.h"
#include "server/matching/loops/loop_candidates.h"
#include "server/matching/loops/loop_search.h"
#include "server/matching/loops/loop_tracking.h"

namespace isthmus::matching {
namespace {

// The same edge from the other map.
SubmapEdge Turned(const SubmapEdge& edge) {
  const Matrix6d A = Adjoint(edge.T_a_b);
  return {edge.submap_b, edge.submap_a, edge.T_a_b.Inverse(), A.transpose() * edge.information * A};
}

// Meetings of submaps of one map, the fresh one, with the other.
class MeetingSearch {
 public:
  // `edges` and `in_vain` are positions of the old map on those of the fresh one.
  MeetingSearch(const JoinedMap& old, const JoinedMap& fresh, const LoopOptions& options,
                const std::stop_token& stop, std::vector<SubmapEdge> edges,
                std::vector<PositionPair> in_vain)
      : old_(old),
        fresh_(fresh),
        options_(options),
        stop_(stop),
        edges_(std::move(edges)),
        in_vain_(std::move(in_vain)) {}

  // Nearest to where the maps are joined first: what is found there tells more of the rest.
  void Run(size_t first_fresh) {
    std::vector<std::pair<double, size_t>> order;
    for (size_t k = first_fresh; k < fresh_.path_lengths.size(); ++k) {
      order.emplace_back(FromJoin(NearestJoin(k), k), k);
    }
    std::sort(order.begin(), order.end());
    for (const auto& [far, k] : order) {
      if (stop_.stop_requested()) return;
      Ask(k);
    }
  }

  const std::vector<SubmapEdge>& ties() const { return ties_; }
  const std::vector<PositionPair>& in_vain() const { return in_vain_; }

 private:
  double FromJoin(const SubmapEdge& join, size_t fresh) const {
    return std::abs(fresh_.path_lengths[join.submap_b] - fresh_.path_lengths[fresh]);
  }

  const SubmapEdge& NearestJoin(size_t fresh) const {
    return *std::min_element(edges_.begin(), edges_.end(), [&](const auto& x, const auto& y) {
      return FromJoin(x, fresh) < FromJoin(y, fresh);
    });
  }

  // Along either direction of the old map.
  void Ask(size_t fresh) {
    size_t searches = 0;
    for (const bool old_backwards : {false, true}) {
      const SubmapEdge join = NearestJoin(fresh);
      JoinedWay& way = WayOver(join, old_backwards, fresh < join.submap_b);
      const LoopScene scene = way.SceneAt(fresh, edges_, options_.drift);
      for (const LoopCandidate& candidate : Candidates(scene, way)) {
        const PositionPair pair{way.PositionOf(candidate.position), static_cast<uint32_t>(fresh)};
        if (WasInVain(pair)) continue;
        if (++searches > kMaxSearches) return;
        const bool thorough = searches == 1;
        const auto closed = CloseLoop(scene, candidate, options_, thorough, &way.submaps());
        if (closed && Take(*closed, way)) return;
        in_vain_.push_back(pair);
      }
    }
  }

  // Submaps known to within what an alignment captures are left to that.
  std::vector<LoopCandidate> Candidates(const LoopScene& scene, JoinedWay& way) const {
    std::vector<LoopCandidate> candidates =
        FindLoopCandidates(scene, options_, way.submaps(), std::numeric_limits<size_t>::max());
    std::erase_if(candidates, [&](const LoopCandidate& candidate) {
      return candidate.position >= way.old_count() || IsKnownWell(candidate);
    });
    return FirstOfEachPass(candidates, scene, options_.min_path_length_m);
  }

  bool WasInVain(const PositionPair& asked) const {
    const double patience = kPatienceShare * options_.min_path_length_m;
    return std::any_of(in_vain_.begin(), in_vain_.end(), [&](const auto& pair) {
      return std::abs(old_.path_lengths[pair.a] - old_.path_lengths[asked.a]) < patience &&
             std::abs(fresh_.path_lengths[pair.b] - fresh_.path_lengths[asked.b]) < patience;
    });
  }

  // False where none of its edges is between the maps.
  bool Take(const LoopClosure& closed, const JoinedWay& way) {
    const size_t before = ties_.size();
    for (const SubmapEdge& edge : closed.edges) {
      if (edge.submap_a >= way.old_count() || edge.submap_b < way.old_count()) continue;
      SubmapEdge tie = edge;
      tie.submap_a = way.PositionOf(edge.submap_a);
      tie.submap_b = way.PositionOf(edge.submap_b);
      ties_.push_back(tie);
      edges_.push_back(tie);
    }
    return ties_.size() > before;
  }

  JoinedWay& WayOver(const SubmapEdge& join, bool old_backwards, bool fresh_backwards) {
    Kept& kept = ways_[old_backwards];
    if (!kept.way || kept.a != join.submap_a || kept.b != join.submap_b ||
        kept.fresh_backwards != fresh_backwards) {
      kept = {join.submap_a, join.submap_b, fresh_backwards,
              std::make_unique<JoinedWay>(old_, fresh_, join, old_backwards, fresh_backwards,
                                          options_.prepared_submaps)};
    }
    return *kept.way;
  }

  struct Kept {
    uint32_t a = 0, b = 0;
    bool fresh_backwards = false;
    std::unique_ptr<JoinedWay> way;
  };

  const JoinedMap& old_;
  const JoinedMap& fresh_;
  const LoopOptions& options_;
  const std::stop_token stop_;
  std::vector<SubmapEdge> edges_, ties_;
  std::vector<PositionPair> in_vain_;
  Kept ways_[2];  // The last, by direction of the old map.
};

template <typename T, typename Turn>
std::vector<T> Each(const std::vector<T>& items, const Turn& turn) {
  std::vector<T> turned;
  turned.reserve(items.size());
  for (const T& item : items) turned.push_back(turn(item));
  return turned;
}

}  // namespace

Meetings FindMeetings(const PreparedMap& a, const PreparedMap& b, const Hypothesis& joined,
                      const LoopOptions& options, const std::stop_token& stop) {
  Meetings found;
  found.memory = joined.meetings;
  found.max_free_space = joined.outdoors ? options.max_free_space_outdoors : options.max_free_space;
  if (joined.joint.edges.empty()) return found;
  const JoinedMap map_a(a, joined.joint.poses.a), map_b(b, joined.joint.poses.b);
  // Other stretches are looked at anew: known badly, their submaps may have slid along a wall.
  std::vector<SubmapEdge> edges = LongestStretch(joined.joint.edges);
  edges.insert(edges.end(), joined.joint.ties.begin(), joined.joint.ties.end());
  MeetingSearch of_b(map_a, map_b, options, stop, edges, found.memory.in_vain);
  of_b.Run(found.memory.asked_b);
  found.ties = of_b.ties();
  found.memory.in_vain = of_b.in_vain();
  // At first all of b was asked, of all of a.
  if (found.memory.asked_a > 0 && found.memory.asked_a < a.submaps().size()) {
    edges.insert(edges.end(), found.ties.begin(), found.ties.end());
    const auto turned = [](const PositionPair& pair) { return PositionPair{pair.b, pair.a}; };
    MeetingSearch of_a(map_b, map_a, options, stop, Each(edges, Turned),
                       Each(found.memory.in_vain, turned));
    of_a.Run(found.memory.asked_a);
    for (const SubmapEdge& tie : of_a.ties()) found.ties.push_back(Turned(tie));
    found.memory.in_vain = Each(of_a.in_vain(), turned);
  }
  found.memory.asked_a = a.submaps().size();
  found.memory.asked_b = b.submaps().size();
  return found;
}

}  // namespace isthmus::matching
