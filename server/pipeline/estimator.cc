#include "server/pipeline/estimator.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <exception>

#include "core/stopwatch.h"

namespace isthmus::server {
namespace {

// Maps that are kept ready at most: the robots of a team.
constexpr size_t kMaxPrepared = 8;
// With more sessions than that, pairs are tried again only when one of them has grown by this
// share: a robot among the maps of a month is not matched with all of them at every submap.
constexpr double kSeldom = 0.25;

bool IsFinished(const SessionEntry& entry) { return entry.record.state == SessionState::kFinished; }

// The next index that a session had when a match of it was computed, which says only of how many
// submaps: those retired since do not make it worth another try.
uint32_t TriedUpTo(const SessionEntry& entry, uint32_t submaps, int64_t computed_ns) {
  // Before its last submaps may be before its last word, too.
  if (IsFinished(entry) && computed_ns < entry.record.finished_ns) return submaps;
  const auto now = static_cast<uint32_t>(entry.submaps.size());
  return entry.next_index() - (now > submaps ? now - submaps : 0);
}

// Whether a newer result takes the place of an accepted one. An accepted match is only given up for
// a better estimate or for a contradiction, not for a moment of doubt.
bool Supersedes(const Match& newer, const Match& older) {
  if (older.state != MatchState::kAccepted) return true;
  return newer.state == MatchState::kAccepted || newer.state == MatchState::kRejected;
}

Estimator::Options WithStop(Estimator::Options options, std::stop_token stop) {
  options.matcher.stop = std::move(stop);
  return options;
}

}  // namespace

Estimator::Estimator(MapState* state, storage::MapStore* store, SubmapCache* submaps,
                     const Clock* clock, const Options& options)
    : state_(state),
      submaps_(submaps),
      prepared_store_(store, submaps),
      clock_(clock),
      options_(WithStop(options, stop_.get_token())),
      journal_(options.work_journal),
      source_([this](const auto& outline) { return GetPrepared(outline); }),
      points_([this](const SubmapId& id) { return submaps_->Get(id); }),
      revisits_(options.revisits, [this](const SubmapId& id) {
        const std::shared_ptr<const Submap> outline = submaps_->Outline(id);
        return outline ? GetPrepared(outline) : nullptr;
      }) {
  for (const auto& [pair, match] : state_->matches) {
    const SessionEntry* a = state_->Find(pair.first);
    const SessionEntry* b = state_->Find(pair.second);
    if (a == nullptr || b == nullptr) continue;
    attempts_[pair] = {TriedUpTo(*a, match.submaps_a, match.computed_ns),
                       TriedUpTo(*b, match.submaps_b, match.computed_ns)};
  }
  // The last of each session may have been stored and not asked.
  for (const auto& [id, entry] : state_->sessions) {
    if (!entry.submaps.empty()) looped_[id] = entry.next_index() - 1;
  }
  thread_ = std::thread([this] { Run(); });
}

Estimator::~Estimator() {
  Stop();
  thread_.join();
}

void Estimator::Stop() {
  std::lock_guard lock(state_->mutex);
  stop_.request_stop();
  journal_.End();
  state_->changed.notify_all();
}

std::shared_ptr<const matching::PreparedSubmap> Estimator::GetPrepared(
    const std::shared_ptr<const Submap>& outline) const {
  if (stop_.stop_requested()) throw Stopped();
  return prepared_store_.Get(outline);
}

bool Estimator::Guard(const std::string& task, const std::function<void()>& work) {
  std::string problem;
  if (journal_.IsPoisonous(task)) {
    problem = absl::StrCat("the server ended while it was at that, ", WorkJournal::kMaxCrashes,
                           " times; please report it. To try again stop the server, remove ",
                           options_.work_journal, " and start it");
  } else {
    journal_.Begin(task);
    try {
      work();
    } catch (const Stopped&) {
      problem = "stopped";
    } catch (const std::exception& e) {
      problem = e.what();
    }
    journal_.End();
  }
  if (problem.empty()) return true;
  if (!stop_.stop_requested() && left_out_.insert(task).second && options_.on_problem) {
    options_.on_problem(absl::StrCat("left out ", task, ": ", problem));
  }
  return false;
}

bool Estimator::IsUpToDate() const {
  return !state_->estimating && !NextForLoops() && !NextPair() && !MustCountRevisits();
}

void Estimator::Run() {
  std::unique_lock lock(state_->mutex);
  Stopwatch round;
  while (!stop_.stop_requested()) {
    if (!state_->estimating) round = Stopwatch();
    if (RunNext(&lock)) continue;
    if (state_->estimating) {
      state_->estimating = false;
      state_->estimation_ms = round.Ms();
      ++state_->estimations;
      Prune();
      state_->changed.notify_all();
    }
    state_->changed.wait(lock);
  }
  state_->estimating = false;
  state_->changed.notify_all();
}

bool Estimator::RunNext(std::unique_lock<std::mutex>* lock) {
  // Loops first: they straighten the maps that pairs are then matched by.
  const std::optional<SubmapId> submap = NextForLoops();
  const std::optional<SessionPair> pair = submap ? std::nullopt : NextPair();
  if (!submap && !pair && !MustCountRevisits()) return false;
  state_->estimating = true;
  lock->unlock();
  if (submap) {
    FindLoops(*submap);
  } else if (pair) {
    Estimate(*pair);
  } else {
    CountRevisits();
  }
  lock->lock();
  return true;
}

std::optional<SubmapId> Estimator::NextForLoops() const {
  if (!options_.loops.enabled) return std::nullopt;
  for (const Placement& placement : state_->revision.placements) {
    const SessionEntry* entry = state_->Find(placement.session);
    if (entry == nullptr) continue;
    const auto it = looped_.find(placement.session);
    const uint32_t next = it == looped_.end() ? 0 : it->second;
    // One at a time: where it leads is what the next one is looked for by.
    const auto first = std::lower_bound(
        placement.submaps.begin(), placement.submaps.end(), next,
        [](const SubmapPose& pose, uint32_t wanted) { return pose.index < wanted; });
    if (first != placement.submaps.end()) return SubmapId{placement.session, first->index};
  }
  return std::nullopt;
}

void Estimator::FindLoops(const SubmapId& submap) {
  matching::LoopQuery query;
  query.session = submap.session;
  std::vector<SubmapPose> poses;
  bool was_last = false;
  {
    std::lock_guard lock(state_->mutex);
    looped_[submap.session] = submap.index + 1;
    const SessionEntry* entry = state_->Find(submap.session);
    const Placement* placement = state_->PlacementOf(submap.session);
    if (entry == nullptr || placement == nullptr) return;
    was_last = IsFinished(*entry) && submap.index + 1 == entry->next_index();
    for (const SubmapPose& pose : placement->submaps) {
      if (pose.index <= submap.index && entry->FindSubmap(pose.index)) poses.push_back(pose);
    }
    for (const auto& [id, loop] : state_->loops) {
      if (loop.session == submap.session) query.known.push_back(loop);
    }
  }
  for (const SubmapPose& pose : poses) {
    std::shared_ptr<const Submap> outline = submaps_->Outline({submap.session, pose.index});
    if (outline == nullptr) continue;
    query.submaps.push_back(std::move(outline));
    query.T_map_submap.push_back(pose.T_map_submap);
  }
  if (query.submaps.empty() || query.submaps.back()->id.index != submap.index) return;
  query.first_new = query.submaps.size() - 1;
  const bool done =
      Guard(absl::StrCat("the loops of ", ToString(submap)), [&] { FindLoops(query); });
  // What it keeps is large, and after a start every session is asked once.
  if (was_last || !done) finders_.erase(submap.session);
}

void Estimator::FindLoops(const matching::LoopQuery& query) {
  const auto [it, is_new] = finders_.try_emplace(query.session, options_.loops, source_, points_);
  // Loops that cannot be stored are lost to this map; those of the next submaps close it too.
  (void)state_->AddLoops(it->second.Find(query));
}

uint32_t Estimator::FreshSubmaps(const SessionEntry& a, const SessionEntry& b,
                                 const Attempt& tried) const {
  const uint32_t fresh_a = a.next_index() - std::min(a.next_index(), tried.next_a);
  const uint32_t fresh_b = b.next_index() - std::min(b.next_index(), tried.next_b);
  const uint32_t fresh = fresh_a + fresh_b;
  if (tried.next_a + tried.next_b == 0 || (IsFinished(a) && IsFinished(b))) return fresh;
  if (state_->sessions.size() > kMaxPrepared) {
    const bool grown_a = fresh_a > 0 && fresh_a >= kSeldom * tried.next_a;
    const bool grown_b = fresh_b > 0 && fresh_b >= kSeldom * tried.next_b;
    if (!grown_a && !grown_b) return 0;
  }
  return fresh >= static_cast<uint32_t>(std::max(options_.rematch_submaps, 1)) ? fresh : 0;
}

std::optional<SessionPair> Estimator::NextPair() const {
  std::optional<SessionPair> best;
  uint32_t most = 0;
  for (auto a = state_->sessions.begin(); a != state_->sessions.end(); ++a) {
    for (auto b = std::next(a); b != state_->sessions.end(); ++b) {
      if (a->second.submaps.empty() || b->second.submaps.empty()) continue;
      const SessionPair pair(a->first, b->first);
      const auto it = attempts_.find(pair);
      const uint32_t fresh =
          FreshSubmaps(a->second, b->second, it == attempts_.end() ? Attempt{} : it->second);
      if (fresh <= most) continue;
      most = fresh;
      best = pair;
    }
  }
  return best;
}

void Estimator::Prune() {
  const auto is_gone = [this](const SessionId& id) { return state_->Find(id) == nullptr; };
  const auto of_gone = [&](const auto& item) {
    return is_gone(item.first.first) || is_gone(item.first.second);
  };
  std::erase_if(attempts_, of_gone);
  std::erase_if(matchers_, of_gone);
  std::erase_if(looped_, [&](const auto& item) { return is_gone(item.first); });
  std::erase_if(finders_, [&](const auto& item) {
    const SessionEntry* entry = state_->Find(item.first);
    return entry == nullptr || IsFinished(*entry);
  });
  std::erase_if(prepared_,
                [&](const Prepared& map) { return is_gone(map->session_map().session); });
}

void Estimator::Estimate(const SessionPair& pair) {
  std::vector<std::shared_ptr<const SubmapInfo>> submaps_a, submaps_b;
  bool finished = false;
  std::optional<Match> older;
  {
    std::lock_guard lock(state_->mutex);
    const SessionEntry* entry_a = state_->Find(pair.first);
    const SessionEntry* entry_b = state_->Find(pair.second);
    if (entry_a == nullptr || entry_b == nullptr) return;
    submaps_a = entry_a->submaps;
    submaps_b = entry_b->submaps;
    finished = IsFinished(*entry_a) && IsFinished(*entry_b);
    if (const auto it = state_->matches.find(pair); it != state_->matches.end()) older = it->second;
    attempts_[pair] = {entry_a->next_index(), entry_b->next_index()};
  }
  const SessionMap a = MapOf(pair.first, submaps_a), b = MapOf(pair.second, submaps_b);
  if (a.submaps.empty() || b.submaps.empty()) return;
  const bool done =
      Guard(absl::StrCat("the match of ", pair.first.value(), " and ", pair.second.value()),
            [&] { Estimate(a, b, finished, older); });
  if (!done) matchers_.erase(pair);
}

void Estimator::Estimate(const SessionMap& a, const SessionMap& b, bool finished,
                         const std::optional<Match>& older) {
  const bool accepted = older && older->state == MatchState::kAccepted;
  const auto [it, is_new] =
      matchers_.try_emplace(SessionPair(a.session, b.session), options_.matcher);
  // After a restart what was found before is one of the guesses.
  if (is_new && accepted) it->second.Suggest(older->T_a_b, older->matcher);
  // The last word on a pair that is still open takes all there is.
  const bool search = finished && !accepted;
  Match match = it->second.Update(*Prepare(a), *Prepare(b), search);
  if (stop_.stop_requested()) throw Stopped();
  match.computed_ns = clock_->NowNs();
  if (older && !Supersedes(match, *older)) return;
  // A match that cannot be stored is found again at the next start; the map goes on without it.
  (void)state_->PutMatch(match);
}

SessionMap Estimator::MapOf(const SessionId& session,
                            const std::vector<std::shared_ptr<const SubmapInfo>>& submaps) const {
  SessionMap map{session, {}, points_};
  for (const auto& submap : submaps) {
    if (auto outline = submaps_->Outline(submap->id)) map.submaps.push_back(std::move(outline));
  }
  return map;
}

Estimator::Prepared Estimator::Prepare(const SessionMap& map) {
  Prepared before;
  for (auto it = prepared_.begin(); it != prepared_.end(); ++it) {
    const SessionMap& held = (*it)->session_map();
    if (held.session != map.session) continue;
    // Submaps are immutable and shared, so the same ones are the same map.
    if (held.submaps == map.submaps) {
      prepared_.splice(prepared_.begin(), prepared_, it);
      return prepared_.front();
    }
    before = *it;
    prepared_.erase(it);
    break;
  }
  prepared_.push_front(before ? std::make_shared<const matching::PreparedMap>(map, *before, source_)
                              : std::make_shared<const matching::PreparedMap>(map, source_));
  const Prepared made = prepared_.front();
  LimitPrepared();
  return made;
}

void Estimator::LimitPrepared() {
  size_t bytes = 0, kept = 0;
  for (auto it = prepared_.begin(); it != prepared_.end();) {
    bytes += (*it)->bytes();
    ++kept;
    const bool fits = kept <= 2 || (kept <= kMaxPrepared && bytes <= options_.prepared_bytes);
    it = fits ? std::next(it) : prepared_.erase(it);
  }
}

bool Estimator::MustCountRevisits() const {
  return options_.revisits.retire && state_->IsPlaced() &&
         state_->revision.revision != counted_revision_;
}

void Estimator::CountRevisits() {
  std::vector<PlacedSubmap> placed;
  {
    std::lock_guard lock(state_->mutex);
    counted_revision_ = state_->revision.revision;
    placed = state_->PlacedSubmaps();
  }
  std::vector<SubmapId> seen_again;
  if (!Guard("which submaps were seen again", [&] { seen_again = revisits_.Update(placed); }))
    return;
  {
    // With an anchored submap its anchor would go.
    std::lock_guard lock(state_->mutex);
    std::erase_if(seen_again, [this](const SubmapId& id) { return state_->anchors.contains(id); });
  }
  // What cannot be stored now is tried again with the next submap.
  (void)state_->Retire(seen_again);
}

}  // namespace isthmus::server
