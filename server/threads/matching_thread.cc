#include "server/threads/matching_thread.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>

#include <algorithm>

#include "core/caught.h"
#include "core/concurrency/thread_role.h"
#include "core/stopwatch.h"
#include "server/matching/index/limits.h"
#include "server/threads/limits.h"

namespace isthmus::server {
namespace {

// The version of no shape.
constexpr uint32_t kOutdated = ~uint32_t{0};  // Format.

// The next index that a session had when a match of it was computed, which says only of how many
// submaps: those retired since do not make it worth another try.
uint32_t TriedUpTo(const SessionView& entry, uint32_t submaps, int64_t computed_ns) {
  // Before its last submaps may be before its last word, too.
  if (IsFinished(entry) && computed_ns < entry.record.finished_ns) return submaps;
  const auto now = static_cast<uint32_t>(entry.submaps.size());
  return entry.next_index() - (now > submaps ? now - submaps : 0);
}

// True if loops have come that the match may not know of.
bool HasNewerLoops(const MapView& view, const SessionId& session, int64_t computed_ns) {
  return std::any_of(view.loops.begin(), view.loops.end(), [&](const auto& entry) {
    const LoopClosure& loop = entry.second;
    return loop.session == session && !loop.rejected && loop.computed_ns > computed_ns;
  });
}

// With the given stop, and somebody to tell problems to.
MatchingThread::Options Complete(MatchingThread::Options options, std::stop_token stop) {
  options.matcher.stop = std::move(stop);
  if (!options.on_problem) options.on_problem = [](const std::string&) {};
  return options;
}

}  // namespace

Attempt MatchingThread::AttemptOf(const MapView& view, const SessionView& a, const SessionView& b,
                                  uint32_t submaps_a, uint32_t submaps_b, int64_t computed_ns) {
  const auto shape = [&](const SessionView& session) {
    return HasNewerLoops(view, session.record.id, computed_ns) ? kOutdated : 0;
  };
  return {TriedUpTo(a, submaps_a, computed_ns), TriedUpTo(b, submaps_b, computed_ns), shape(a),
          shape(b)};
}

MatchingThread::MatchingThread(MapWriter* map, Activity* activity, storage::MapStore* store,
                               SubmapCache* submaps, const Clock* clock, const Options& options)
    : map_(map),
      activity_(activity),
      store_(store),
      submaps_(submaps),
      prepared_store_(store, submaps),
      queue_(store->jobs()),
      clock_(clock),
      options_(Complete(options, stop_.get_token())),
      schedule_{options.loops.enabled, options.revisits.retire, options.rematch_submaps},
      guard_(options.crash_journal, clock, stop_.get_token(), options_.on_problem),
      runner_(store, {.prepared_bytes = options.prepared_bytes, .submaps = submaps, .wait = wait_}),
      shapes_([this](const SubmapId& id) { return OutlineOf(id); }),
      revisits_(options.revisits, [this](const SubmapId& id) {
        const std::shared_ptr<const Submap> outline = OutlineOf(id);
        return outline ? GetPrepared(outline) : nullptr;
      }) {
  const MapWriter::View view = map_->view();
  for (const auto& [pair, match] : view->matches) {
    const SessionView* a = view->Find(pair.first);
    const SessionView* b = view->Find(pair.second);
    if (a == nullptr || b == nullptr) continue;
    ledger_.attempts[pair] =
        AttemptOf(*view, *a, *b, match.submaps_a, match.submaps_b, match.computed_ns);
  }
  ReadProgress();
  RestorePartners(*view);
  ledger_.unfinished = PairsEndedAt(*view);
  (void)shapes_.FindOutdated(*view);  // None yet.
  for (const auto& [id, session] : view->sessions) ledger_.looped[id] = FirstUnsearched(session);
  AdoptJobs(*view);
  set_aside_count_ = set_aside_.size();
  thread_ = std::thread([this] { Run(); });
}

MatchingThread::~MatchingThread() {
  Stop();
  thread_.join();
}

void MatchingThread::ReadProgress() {
  const auto stored = store_->ListMatchingProgress();
  if (!stored.ok()) {
    options_.on_problem(absl::StrCat("matching begins anew, as its progress cannot be read: ",
                                     stored.status().message()));
    return;
  }
  for (const storage::MatchingProgress& progress : *stored) progress_[progress.session] = progress;
}

void MatchingThread::StoreProgress(const SessionId& session) const {
  // Without it some work is done again after the next start.
  (void)store_->Write({.matching_progress = {progress_.at(session)}});
}

void MatchingThread::Stop() {
  stop_.request_stop();
  guard_.EndTask();
  map_->changed().Notify();
}

std::shared_ptr<const matching::PreparedSubmap> MatchingThread::GetPrepared(
    const std::shared_ptr<const Submap>& outline) const {
  const std::stop_token stop = stop_.get_token();
  const auto prepared = AwaitStore([&] { return prepared_store_.Get(outline, stop); }, wait_, stop);
  return prepared.ok() ? *prepared : std::make_shared<const matching::PreparedSubmap>(outline);
}

std::shared_ptr<const Submap> MatchingThread::OutlineOf(const SubmapId& submap) const {
  const auto outline =
      AwaitStore([&] { return submaps_->TryOutline(submap); }, wait_, stop_.get_token());
  return outline.value_or(nullptr);
}

bool MatchingThread::WaitForStoreSince(const Stopwatch& since) const {
  if (!store_->IsRemote() && since.Ms() >= kStoreAwayMs) return false;
  LookAgainSoon();
  return true;
}

void MatchingThread::LookAgainSoon() const {
  // An end of the process while it waits has nothing to do with the task.
  guard_.EndTask();
  map_->changed().WaitPast(map_->changed().count(), absl::Now() + kStoreAwayLook);
}

JobResult MatchingThread::RunHere(const Job& job) {
  std::optional<StageTimer> timer;
  if (std::holds_alternative<PairJob>(job)) timer.emplace(activity_->observer(), Stage::kMatch);
  if (std::holds_alternative<LoopJob>(job)) {
    timer.emplace(activity_->observer(), Stage::kLoopSearch);
  }
  absl::StatusOr<JobResult> result = runner_.Run(job, stop_.get_token());
  prepared_bytes_ = runner_.prepared_bytes();
  if (stop_.stop_requested()) throw Stopped();
  const auto* loops = std::get_if<LoopJob>(&job);
  if (loops != nullptr && runner_.has_left_out()) has_gaps_.insert(loops->session.session);
  if (!result.ok()) throw StatusError(result.status());
  return *std::move(result);
}

void MatchingThread::AwaitStored(const std::function<absl::Status()>& write) const {
  while (true) {
    const absl::Status status = write();
    if (status.ok()) return;
    // Nobody finds it a second time before the next start, and without it the map would settle.
    if (!absl::IsUnavailable(status) && !absl::IsResourceExhausted(status)) {
      throw StatusError(status);
    }
    if (stop_.stop_requested()) throw Stopped();
    LookAgainSoon();
  }
}

void MatchingThread::Run() {
  NameThread("matching");
  LowerPriority(kMatchingNice);
  Stopwatch round;
  bool is_at_work = false;
  while (!stop_.stop_requested()) {
    const uint64_t seen = map_->changed().count();
    const MapWriter::View view = map_->view();
    if (!is_at_work) round = Stopwatch();
    bool has_more = false;
    try {
      has_more = RunNext(*view);
    } catch (...) {
      // Between tasks, so of none of them in particular: whatever is due is after the next change.
      options_.on_problem(
          absl::StrCat("matching waits for the next change: ", CaughtStatus().message()));
    }
    if (has_more) {
      is_at_work = true;
      continue;
    }
    if (!ledger_.posted.empty()) {
      map_->changed().WaitPast(seen, absl::Now() + absl::Milliseconds(kLookForResultsMs));
      continue;
    }
    if (std::exchange(is_at_work, false)) {
      activity_->NoteEstimation(round.Ms());
      ForgetGone(*view);
    }
    up_to_date_with_ = view->serial;
    activity_->changed().Notify();
    // Workers come and go, and time goes by, without a change of the map.
    absl::Duration look = absl::InfiniteDuration();
    if (queue_ != nullptr) look = kLookForWorkersIdle;
    if (guard_.left_out() > 0) look = kLookForLeftOut;
    map_->changed().WaitPast(seen, absl::Now() + look);
  }
}

bool MatchingThread::RunNext(const MapView& view) {
  guard_.TryAgain([this](const JobKey& key) {
    ledger_.Forget(key);
    up_to_date_with_ = ~uint64_t{0};
  });
  FollowWorkers(view);
  if (!NextForLoops(view, ledger_, schedule_)) {
    // No sooner: every loop that is found changes the shapes.
    ledger_.outdated_shapes.merge(shapes_.FindOutdated(view));
    ledger_.shapes = shapes_.versions();
  }
  const NextJob next = ChooseNext(view, ledger_, schedule_);
  waiting_submaps_ = next.waiting_submaps;
  if (next.waiting_pairs) waiting_pairs_ = *next.waiting_pairs;
  if (!next.key) return false;
  if (const auto* loops = std::get_if<LoopKey>(&*next.key)) {
    FindLoops(view, loops->submap);
  } else if (const auto* shape = std::get_if<ShapeKey>(&*next.key)) {
    UpdateShape(view, shape->session);
  } else if (const auto* index = std::get_if<IndexKey>(&*next.key)) {
    IndexSession(view, index->session);
  } else if (const auto* match = std::get_if<MatchKey>(&*next.key)) {
    EstimateMatch(view, match->pair);
  } else {
    CountRevisits(view);
  }
  return true;
}

void MatchingThread::ForgetGone(const MapView& view) {
  const auto is_gone = [&view](const SessionId& id) { return view.Find(id) == nullptr; };
  ledger_.ForgetGone(view);
  std::erase_if(pair_memories_, [&](const auto& item) {
    return is_gone(item.first.first) || is_gone(item.first.second);
  });
  std::erase_if(has_gaps_, is_gone);
  std::erase_if(progress_, [&](const auto& item) { return is_gone(item.first); });
  std::erase_if(memories_, [&](const auto& item) {
    const SessionView* entry = view.Find(item.first);
    return entry == nullptr || IsFinished(*entry);
  });
  runner_.ForgetIf(is_gone);
  prepared_bytes_ = runner_.prepared_bytes();
  index_.ForgetIf(is_gone);
  ledger_.ranked = index_.Rank(matching::kLookedPartners);
}

void MatchingThread::CountRevisits(const MapView& view) {
  ledger_.counted_revision = view.revision->revision;
  const std::vector<PlacedSubmap> placed = view.PlacedSubmaps();
  (void)guard_.Run(RevisitsKey(), [&] {
    const auto finished_ns = [&](const SessionId& session) {
      const SessionView* found = view.Find(session);
      return found != nullptr ? found->record.finished_ns : 0;
    };
    std::vector<SubmapId> seen_again = revisits_.Update(placed, clock_->NowNs(), finished_ns);
    // With an anchored submap its anchor would go.
    const MapWriter::View now = map_->view();
    std::erase_if(seen_again, [&](const SubmapId& id) { return now->anchors.contains(id); });
    AwaitStored([&] { return map_->RetireSubmaps(seen_again); });
  });
}

}  // namespace isthmus::server
