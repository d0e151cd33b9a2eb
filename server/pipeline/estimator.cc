#include "server/pipeline/estimator.h"

#include <algorithm>

#include "core/stopwatch.h"

namespace isthmus::server {
namespace {

// Maps that are kept ready: the robots of a team. Each takes about as much memory as its submaps.
constexpr size_t kMaxPrepared = 8;

SessionMap MapOf(const SessionEntry& entry) { return {entry.record.id, entry.submaps}; }

// Whether a newer result takes the place of an accepted one. An accepted match is only given up for
// a better estimate or for a contradiction, not for a moment of doubt.
bool Supersedes(const Match& newer, const Match& older) {
  if (older.state != MatchState::kAccepted) return true;
  return newer.state == MatchState::kAccepted || newer.state == MatchState::kRejected;
}

}  // namespace

Estimator::Estimator(MapState* state, storage::MapStore* store, const Clock* clock,
                     const Options& options)
    : state_(state), prepared_store_(store), clock_(clock), options_(options) {
  for (const auto& [pair, match] : state_->matches) {
    attempts_[pair] = {match.submaps_a, match.submaps_b};
  }
  thread_ = std::thread([this] { Run(); });
}

Estimator::~Estimator() {
  Stop();
  thread_.join();
}

void Estimator::Stop() {
  std::lock_guard lock(state_->mutex);
  stop_ = true;
  state_->changed.notify_all();
}

void Estimator::Run() {
  std::unique_lock lock(state_->mutex);
  Stopwatch round;
  while (!stop_) {
    const std::optional<SessionPair> pair = NextPair();
    if (!pair) {
      if (state_->estimating) {
        state_->estimating = false;
        state_->estimation_ms = round.Ms();
        ++state_->estimations;
        Prune();
        state_->changed.notify_all();
      }
      state_->changed.wait(lock);
      continue;
    }
    if (!state_->estimating) {
      state_->estimating = true;
      round = Stopwatch();
    }
    lock.unlock();
    Estimate(*pair);
    lock.lock();
  }
  state_->estimating = false;
  state_->changed.notify_all();
}

std::optional<SessionPair> Estimator::NextPair() const {
  std::optional<SessionPair> best;
  uint32_t most = 0;
  for (auto a = state_->sessions.begin(); a != state_->sessions.end(); ++a) {
    for (auto b = std::next(a); b != state_->sessions.end(); ++b) {
      if (a->second.submaps.empty() || b->second.submaps.empty()) continue;
      const SessionPair pair(a->first, b->first);
      const auto it = attempts_.find(pair);
      const Attempt tried = it == attempts_.end() ? Attempt{} : it->second;
      const auto had = tried.submaps_a + tried.submaps_b;
      const auto have = static_cast<uint32_t>(a->second.submaps.size() + b->second.submaps.size());
      if (have <= had) continue;
      const bool final = a->second.record.state == SessionState::kFinished &&
                         b->second.record.state == SessionState::kFinished;
      const uint32_t wanted =
          had == 0 || final ? 1 : static_cast<uint32_t>(std::max(options_.rematch_submaps, 1));
      if (have - had >= wanted && have - had > most) {
        most = have - had;
        best = pair;
      }
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
  std::erase_if(prepared_,
                [&](const Prepared& map) { return is_gone(map->session_map().session); });
}

void Estimator::Estimate(const SessionPair& pair) {
  SessionMap a, b;
  bool finished = false;
  std::optional<Match> older;
  {
    std::lock_guard lock(state_->mutex);
    const SessionEntry* entry_a = state_->Find(pair.first);
    const SessionEntry* entry_b = state_->Find(pair.second);
    if (entry_a == nullptr || entry_b == nullptr) return;
    a = MapOf(*entry_a);
    b = MapOf(*entry_b);
    finished = entry_a->record.state == SessionState::kFinished &&
               entry_b->record.state == SessionState::kFinished;
    if (const auto it = state_->matches.find(pair); it != state_->matches.end()) older = it->second;
    attempts_[pair] = {static_cast<uint32_t>(a.submaps.size()),
                       static_cast<uint32_t>(b.submaps.size())};
  }
  const bool accepted = older && older->state == MatchState::kAccepted;
  const auto [it, is_new] = matchers_.try_emplace(pair, options_.matcher);
  // After a restart what was found before is one of the guesses.
  if (is_new && accepted) it->second.Suggest(older->T_a_b, older->matcher);
  // The last word on a pair that is still open takes all there is.
  const bool search = finished && !accepted;
  Match match = it->second.Update(*Prepare(a), *Prepare(b), search);
  match.computed_ns = clock_->NowNs();
  if (older && !Supersedes(match, *older)) return;
  // A match that cannot be stored is found again at the next start; the map goes on without it.
  (void)state_->PutMatch(match);
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
  const matching::SubmapSource source = [this](const std::shared_ptr<const Submap>& submap) {
    return prepared_store_.Get(submap);
  };
  prepared_.push_front(before ? std::make_shared<const matching::PreparedMap>(map, *before, source)
                              : std::make_shared<const matching::PreparedMap>(map, source));
  if (prepared_.size() > kMaxPrepared) prepared_.pop_back();
  return prepared_.front();
}

}  // namespace isthmus::server
