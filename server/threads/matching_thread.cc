#include "server/threads/matching_thread.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "core/caught.h"
#include "core/concurrency/thread_role.h"
#include "core/stopwatch.h"
#include "server/matching/index/limits.h"
#include "server/threads/limits.h"

namespace isthmus::server {
namespace {

// With the given stop, and somebody to tell problems to.
MatchingThread::Options Complete(MatchingThread::Options options, std::stop_token stop) {
  options.matcher.stop = std::move(stop);
  if (!options.on_problem) options.on_problem = [](const std::string&) {};
  return options;
}

}  // namespace

MatchingThread::MatchingThread(MapWriter* map, Activity* activity, storage::MapStore* store,
                               SubmapCache* submaps, const Clock* clock, const Options& options)
    : map_(map),
      activity_(activity),
      store_(store),
      submaps_(submaps),
      prepared_store_(store, submaps),
      clock_(clock),
      options_(Complete(options, stop_.get_token())),
      schedule_{options.loops.enabled, options.revisits.retire, options.rematch_submaps},
      guard_(options.crash_journal, clock, stop_.get_token(), options_.on_problem),
      progress_(store, &ledger_, options_.on_problem),
      runner_(store, {.prepared_bytes = options.prepared_bytes, .submaps = submaps, .wait = wait_}),
      shapes_([this](const SubmapId& id) { return OutlineOf(id); }),
      revisits_(options.revisits, [this](const SubmapId& id) { return GetPrepared(id); }),
      queue_(store->jobs(), &ledger_, &guard_,
             {.take = [this](const MapView& view, const JobKey& key,
                             const JobResult& result) { return TakeEnded(view, key, result); },
              .on_failed =
                  [this](const JobKey& key) {
                    const auto* loops = std::get_if<LoopKey>(&key);
                    if (loops != nullptr) has_gaps_.insert(loops->submap.session);
                  },
              .on_due = [this] { up_to_date_with_ = ~uint64_t{0}; },
              .on_problem = options_.on_problem}) {
  const MapWriter::View view = map_->view();
  const auto is_there = [&view](const SessionPair& pair) {
    return view->Find(pair.first) != nullptr && view->Find(pair.second) != nullptr;
  };
  for (const auto& [pair, match] : view->matches) {
    if (!is_there(pair)) continue;
    ledger_.attempts[pair] =
        AttemptOf(*view, pair, match.submaps_a, match.submaps_b, match.computed_ns);
  }
  progress_.RestorePartners(*view);
  for (const JobKey& key : guard_.ended_at()) {
    const auto* match = std::get_if<MatchKey>(&key);
    if (match != nullptr && is_there(match->pair)) ledger_.unfinished.push_back(match->pair);
  }
  (void)shapes_.FindOutdated(*view);  // None yet.
  for (const auto& [id, session] : view->sessions) {
    ledger_.looped[id] =
        options_.loops.enabled ? progress_.FirstUnsearched(session) : session.next_index();
  }
  queue_.Adopt(*view);
  thread_ = std::thread([this] { Run(); });
}

MatchingThread::~MatchingThread() {
  Stop();
  thread_.join();
}

void MatchingThread::Stop() {
  stop_.request_stop();
  guard_.EndTask();
  map_->changed().Notify();
}

std::shared_ptr<const matching::PreparedSubmap> MatchingThread::GetPrepared(
    const SubmapId& submap) const {
  const std::shared_ptr<const Submap> outline = OutlineOf(submap);
  if (outline == nullptr) return nullptr;
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
  // An end of the process while it waits has nothing to do with the task.
  guard_.EndTask();
  map_->changed().WaitPast(map_->changed().count(), absl::Now() + kStoreAwayLook);
  return true;
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
    if (queue_.is_there()) look = kLookForWorkersIdle;
    if (guard_.left_out() > 0) look = kLookForLeftOut;
    map_->changed().WaitPast(seen, absl::Now() + look);
  }
}

bool MatchingThread::RunNext(const MapView& view) {
  guard_.TryAgain([this](const JobKey& key) {
    ledger_.Forget(key);
    up_to_date_with_ = ~uint64_t{0};
  });
  queue_.Follow(view);
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
    const bool done = guard_.Run(*shape, [&] { shapes_.Update(view, shape->session); });
    if (!done) shapes_.LeaveOut(shape->session);
    ledger_.outdated_shapes.erase(shape->session);
  } else if (const auto* index = std::get_if<IndexKey>(&*next.key)) {
    IndexSession(view, index->session);
  } else if (const auto* match = std::get_if<MatchKey>(&*next.key)) {
    EstimateMatch(view, match->pair);
  } else {
    CountRevisits(view);
  }
  return true;
}

void MatchingThread::Do(const MapView& view, const JobKey& key, const Job& job, bool by_workers) {
  if (by_workers) return queue_.Post(key, job);
  const JobResult result = RunHere(job);
  AwaitStored([&] { return Take(view, key, result); });
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
    (void)WaitForStoreSince(Stopwatch());
  }
}

absl::Status MatchingThread::TakeEnded(const MapView& view, const JobKey& key,
                                       const JobResult& result) {
  if (absl::Status status = Take(view, key, result); !status.ok()) return status;
  const auto* index = std::get_if<IndexKey>(&key);
  const auto* match = std::get_if<MatchKey>(&key);
  if (index != nullptr) progress_.ChoosePartners(view, index->session);
  if (match != nullptr && !ledger_.posted.contains(key)) {
    const Match& made = std::get<PairResult>(result).match;
    ledger_.attempts[match->pair] =
        AttemptOf(view, match->pair, made.submaps_a, made.submaps_b, made.computed_ns);
  }
  return absl::OkStatus();
}

absl::Status MatchingThread::Take(const MapView& view, const JobKey& key, const JobResult& result) {
  if (const auto* match = std::get_if<PairResult>(&result)) {
    return TakeMatch(view, std::get<MatchKey>(key).pair, *match);
  }
  if (const auto* loops = std::get_if<LoopResult>(&result)) {
    return TakeLoops(std::get<LoopKey>(key).submap, *loops);
  }
  for (const PlanScore& plan : std::get<PlanScores>(result)) {
    if (!plan.score || !std::isfinite(*plan.score)) continue;
    index_.Put(std::get<IndexKey>(key).session, plan.other, *plan.score);
  }
  ledger_.ranked = index_.Rank(matching::kLookedPartners);
  return absl::OkStatus();
}

void MatchingThread::ForgetGone(const MapView& view) {
  const auto is_gone = [&view](const SessionId& id) { return view.Find(id) == nullptr; };
  ledger_.ForgetGone(view);
  std::erase_if(pair_memories_, [&](const auto& item) {
    return is_gone(item.first.first) || is_gone(item.first.second);
  });
  std::erase_if(has_gaps_, is_gone);
  progress_.ForgetIf(is_gone);
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
