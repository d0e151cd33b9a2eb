// Matches: how two sessions' maps lie to each other.
#include <algorithm>
#include <iterator>
#include <utility>

#include "server/jobs/job_runner.h"
#include "server/threads/known_anchors.h"
#include "server/threads/limits.h"
#include "server/threads/matching_thread.h"

namespace isthmus::server {
namespace {

// True if a newer result takes the place of an older one. An accepted match is only given up for a
// better estimate, for a contradiction, or where it has become doubtful: new submaps may not bear
// it out, and anchors that spoke for it may be gone. A moment of doubt is not enough.
bool Supersedes(const Match& newer, const Match& older) {
  return older.state != MatchState::kAccepted || newer.state == MatchState::kAccepted ||
         newer.state == MatchState::kRejected || newer.confidence < kGivenUpBelow;
}

MapOfJob JobMapOf(const ShapedMap& shaped) {
  MapOfJob map = MakeMapOfJob(shaped.map.session, shaped.map.submaps);
  if (shaped.shape) map.shape = *shaped.shape;
  return map;
}

}  // namespace

uint32_t MatchingThread::FreshSubmaps(const MapView& view, const SessionView& a,
                                      const SessionView& b, const Attempt& tried) const {
  const uint32_t fresh_a = a.next_index() - std::min(a.next_index(), tried.next_a);
  const uint32_t fresh_b = b.next_index() - std::min(b.next_index(), tried.next_b);
  const uint32_t moved = (tried.shape_a != shapes_.version(a.record.id) ? 1 : 0) +
                         (tried.shape_b != shapes_.version(b.record.id) ? 1 : 0);
  const uint32_t fresh = fresh_a + fresh_b + moved;
  if (tried.next_a + tried.next_b == 0 || (IsFinished(a) && IsFinished(b))) return fresh;
  if (view.sessions.size() > kMaxPreparedMaps) {
    const bool grown_a = fresh_a > 0 && fresh_a >= kSeldomGrowth * tried.next_a;
    const bool grown_b = fresh_b > 0 && fresh_b >= kSeldomGrowth * tried.next_b;
    if (!grown_a && !grown_b) return 0;
  }
  const auto least = static_cast<uint32_t>(std::max(options_.rematch_submaps, 1));
  return moved > 0 || fresh >= least ? fresh : 0;
}

std::optional<SessionPair> MatchingThread::NextPair(const MapView& view) {
  const bool selects = SelectsPartners(view);
  const std::optional<SessionPair> partners = selects ? NextPartners(view) : std::nullopt;
  uint64_t waiting = partners ? 1 : 0;
  const KnownAnchors anchors(view);
  std::optional<SessionPair> best;
  uint32_t most = 0;
  const auto consider = [&](const SessionView& a, const SessionView& b, const Attempt& tried) {
    const SessionPair pair(a.record.id, b.record.id);
    const uint32_t fresh =
        IsPosted(MatchKey{pair}) ? 0 : Evidence(view, a, b, tried, anchors.Version(pair));
    waiting += fresh > 0 ? 1 : 0;
    if (fresh <= most) return;
    most = fresh;
    best = pair;
  };
  if (selects) {
    // Of thousands of sessions a few pairs were tried; the same order as below.
    for (const auto& [pair, tried] : attempts_) {
      const SessionView *a = view.Find(pair.first), *b = view.Find(pair.second);
      if (a != nullptr && b != nullptr && IsMatchable(*a) && IsMatchable(*b)) {
        consider(*a, *b, tried);
      }
    }
    waiting_pairs_ = waiting;
    return partners ? partners : best;
  }
  for (auto a = view.sessions.begin(); a != view.sessions.end(); ++a) {
    if (!IsMatchable(a.value())) continue;
    for (auto b = std::next(a); b != view.sessions.end(); ++b) {
      if (!IsMatchable(b.value())) continue;
      const auto it = attempts_.find(SessionPair(a.key(), b.key()));
      consider(a.value(), b.value(), it == attempts_.end() ? Attempt{} : it->second);
    }
  }
  waiting_pairs_ = waiting;
  return best;
}

uint32_t MatchingThread::Evidence(const MapView& view, const SessionView& a, const SessionView& b,
                                  const Attempt& tried, uint64_t anchors) const {
  const uint32_t fresh = FreshSubmaps(view, a, b, tried);
  return fresh == 0 && tried.anchors != anchors ? 1 : fresh;
}

void MatchingThread::EstimateMatch(const MapView& view, const SessionPair& pair) {
  const SessionView* session_a = view.Find(pair.first);
  const SessionView* session_b = view.Find(pair.second);
  if (session_a == nullptr || session_b == nullptr) return;
  const std::shared_ptr<const Match> older = view.matches.Get(pair);
  const KnownAnchors anchors(view);
  const auto at = attempts_.find(pair);
  const Attempt tried = at == attempts_.end() ? Attempt{} : at->second;
  const Occasion occasion = {
      .last_submaps = IsFinished(*session_a) && IsFinished(*session_b) &&
                      FreshSubmaps(view, *session_a, *session_b, tried) > 0,
      .first_look = SelectsPartners(view) && !AreSegments(*session_a, *session_b)};
  attempts_[pair] = {session_a->next_index(), session_b->next_index(), shapes_.version(pair.first),
                     shapes_.version(pair.second), anchors.Version(pair)};
  last_pair_ = pair;
  if (IsSetAside(MatchKey{pair})) return;
  const bool done = RunGuarded(MatchKey{pair}, [&] {
    const ShapedMap a = MapOf(view, *session_a), b = MapOf(view, *session_b);
    if (a.map.submaps.empty() || b.map.submaps.empty()) return;
    const PairJob job = MakePairJob(a, b, anchors.Of(pair), occasion, older.get());
    if (has_workers_) return Post(MatchKey{pair}, EncodeJob(job));
    const StageTimer timer(activity_->observer(), Stage::kMatch);
    PairResult result = RunHere<PairResult>(job);
    prepared_bytes_ = runner_.prepared_bytes();
    AwaitStored([&] { return TakeMatch(result.match, older.get()); });
    pair_memories_[pair] = std::move(result.memory);
  });
  if (!done) pair_memories_.erase(pair);
}

PairJob MatchingThread::MakePairJob(const ShapedMap& a, const ShapedMap& b,
                                    std::vector<Anchor> anchors, const Occasion& occasion,
                                    const Match* older) const {
  PairJob job{.a = JobMapOf(a), .b = JobMapOf(b), .anchors = std::move(anchors)};
  const auto memory = pair_memories_.find(SessionPair(a.map.session, b.map.session));
  if (memory != pair_memories_.end()) {
    job.memory = memory->second;
  } else if (older != nullptr) {
    job.known = *older;
  }
  job.options = options_.matcher;
  job.options.first_look = occasion.first_look;
  job.search = MustSearch(occasion, older);
  job.posted_ns = clock_->NowNs();
  return job;
}

bool MatchingThread::MustSearch(const Occasion& occasion, const Match* older) {
  const bool accepted = older != nullptr && older->state == MatchState::kAccepted;
  return occasion.last_submaps && !accepted;
}

absl::Status MatchingThread::TakeMatch(const Match& match, const Match* older) {
  if (older != nullptr && !Supersedes(match, *older)) return absl::OkStatus();
  return map_->PutMatch(match);
}

void MatchingThread::UpdateShapes(const MapView& view) {
  for (const SessionId& id : shapes_.FindOutdated(view)) {
    const bool done = RunGuarded(ShapeKey{id}, [&] { shapes_.Update(view, id); });
    if (!done) shapes_.LeaveOut(id);
  }
}

ShapedMap MatchingThread::MapOf(const MapView& view, const SessionView& session) {
  SessionShapes::Shaped shaped = shapes_.Of(view, session);
  return {{session.record.id, std::move(shaped.submaps), nullptr}, std::move(shaped.shape)};
}

}  // namespace isthmus::server
