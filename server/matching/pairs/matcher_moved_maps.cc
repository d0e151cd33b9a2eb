// Pairs of maps that are not as they were: submaps retired, or moved by loops.
#include <algorithm>
#include <utility>

#include "core/stopwatch.h"
#include "server/matching/pairs/matcher.h"
#include "server/matching/pairs/odom_transform.h"

namespace isthmus::matching {
namespace {

// The edges between submaps that the maps still have, which they name by position.
std::vector<SubmapEdge> Positions(const PreparedMap& a, const PreparedMap& b,
                                  const std::vector<SubmapEdge>& edges) {
  const auto position = [](const PreparedMap& map, uint32_t* index) {
    const auto& submaps = map.session_map().submaps;
    const auto at = std::find_if(submaps.begin(), submaps.end(),
                                 [&](const auto& submap) { return submap->id.index == *index; });
    *index = static_cast<uint32_t>(at - submaps.begin());
    return at != submaps.end();
  };
  std::vector<SubmapEdge> there;
  for (SubmapEdge edge : edges) {
    if (position(a, &edge.submap_a) && position(b, &edge.submap_b)) there.push_back(edge);
  }
  return there;
}

SessionMap Only(const std::vector<size_t>& kept, SessionMap map) {
  std::vector<std::shared_ptr<const Submap>> submaps;
  submaps.reserve(kept.size());
  for (const size_t k : kept) submaps.push_back(map.submaps[k]);
  map.submaps = std::move(submaps);
  return map;
}

}  // namespace

void PairMatcher::SuggestKnown(const PreparedMap& a, const PreparedMap& b) {
  if (known_.empty()) return;
  const FramePoses odometry = FramePoses::ByOdometry(a, b);
  const FramePoses here = FramePoses::AsMatched(a.session_map(), b.session_map());
  for (const Match& known : std::exchange(known_, {})) {
    const Pose T_a_b = a.shape() || b.shape()
                           ? Reframe(odometry, here, Positions(a, b, known.edges), known.T_a_b)
                           : known.T_a_b;
    suggested_.push_back({T_a_b, 0, known.matcher});
  }
}

PairMatcher::Maps PairMatcher::FollowMaps(const SessionMap& a, const SessionMap& b) {
  const auto kept_a = FindSameSubmaps(memory_.a, a), kept_b = FindSameSubmaps(memory_.b, b);
  if (memory_.searched == 0 || !kept_a || !kept_b) return Maps::kOthers;
  const bool moved = !FindKept(memory_.a, a) || !FindKept(memory_.b, b);
  if (kept_a->size() < memory_.a.submaps.size() || kept_b->size() < memory_.b.submaps.size()) {
    for (Hypothesis& h : memory_.hypotheses) KeepOnly(*kept_a, *kept_b, &h);
    memory_.a = Only(*kept_a, memory_.a);
    memory_.b = Only(*kept_b, memory_.b);
  }
  if (moved) {
    const FramePoses from = FramePoses::AsMatched(memory_.a, memory_.b);
    const FramePoses to = FramePoses::AsMatched(a, b);
    for (Hypothesis& h : memory_.hypotheses) h.T_a_b = Reframe(from, to, h.joint.edges, h.T_a_b);
  }
  const auto end = [](const auto& submaps, size_t count) {
    return submaps.begin() + static_cast<std::ptrdiff_t>(count);
  };
  memory_.a.submaps.assign(a.submaps.begin(), end(a.submaps, kept_a->size()));
  memory_.b.submaps.assign(b.submaps.begin(), end(b.submaps, kept_b->size()));
  memory_.come += a.submaps.size() - kept_a->size() + b.submaps.size() - kept_b->size();
  return moved ? Maps::kMoved : Maps::kGrown;
}

void PairMatcher::JudgeAgain(const PreparedMap& a, const PreparedMap& b, Match* match) {
  Stopwatch watch;
  for (Hypothesis& h : std::exchange(memory_.hypotheses, {})) {
    memory_.hypotheses.push_back(std::move(h));
    JudgeLast(a, b);
  }
  match->candidates = static_cast<uint32_t>(memory_.hypotheses.size());
  match->stages.push_back({"again", watch.Lap()});
  Decide(a, b, match);
}

}  // namespace isthmus::matching
