#include "server/threads/composition_thread.h"

#include <absl/cleanup/cleanup.h>
#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include <algorithm>
#include <set>
#include <utility>

#include "core/caught.h"
#include "core/concurrency/thread_role.h"
#include "server/threads/limits.h"

namespace isthmus::server {

CompositionThread::CompositionThread(MapWriter* map, Activity* activity, SubmapReader reader,
                                     const composition::ComposerOptions& options, double interval_s,
                                     OnProblem on_problem, OnComposed on_composed)
    : map_(map),
      activity_(activity),
      read_(std::move(reader)),
      reader_([this](const SubmapId& id) {
        const auto failed = failures_.find(id);
        return failed == failures_.end() || failed->second < kMaxFailures ? Read(id) : nullptr;
      }),
      options_(options),
      interval_s_(interval_s),
      on_problem_(std::move(on_problem)),
      on_composed_(std::move(on_composed)) {
  MakeComposer();
  auto first = FirstMap();
  if (loading_ != nullptr) {
    map_->ShowComposed(std::move(first));
  } else {
    Show(*map_->view(), std::move(first));
    turns_.NoteShown({});
  }
  std::set<SubmapId> known = composer_->Known(map_->view()->PlacedSubmaps());
  if (!known.empty()) turns_.NoteKept(std::move(known));
  thread_ = std::thread([this] { Run(); });
}

CompositionThread::~CompositionThread() {
  Stop();
  thread_.join();
}

void CompositionThread::Stop() {
  stop_ = true;
  map_->changed().Notify();
}

composition::Composer::Memory CompositionThread::memory() const {
  MutexLock lock(&memory_mutex_);
  return memory_;
}

std::shared_ptr<const ComposedMap> CompositionThread::FirstMap() {
  uint32_t components = 0;
  std::set<RobotId> robots;
  const MapWriter::View view = map_->view();
  for (const Placement& placement : view->revision->placements) {
    if (placement.submaps.empty()) continue;
    components = std::max(components, placement.component + 1);
    const SessionView* session = view->Find(placement.session);
    if (session != nullptr) robots.insert(session->record.robot);
  }
  loading_ =
      std::make_shared<LoadingMap>(std::vector<RobotId>(robots.begin(), robots.end()), components);
  if (components > 0) return loading_;
  // Nothing is stored, so there is nothing to wait for.
  auto empty = composer_->Compose(0, {}, reader_);
  if (!empty.ok()) return loading_;
  loading_ = nullptr;
  return *std::move(empty);
}

void CompositionThread::MakeComposer() {
  composer_ = std::make_unique<composition::Composer>(options_);
  composer_->TellLost([this] { map_->changed().Notify(); });
}

void CompositionThread::Show(const MapView& composed_of, std::shared_ptr<const ComposedMap> map) {
  map_->ShowComposed(map);
  if (on_composed_) on_composed_(composed_of, map);
}

absl::StatusOr<std::shared_ptr<const ComposedMap>> CompositionThread::Compose(
    int64_t revision, const CompositionTurns::Turn& turn) {
  try {
    if (composer_ == nullptr) MakeComposer();
    const auto progress = [&](double share) {
      if (loading_ != nullptr) loading_->SetDone(share);
      return KeepsOn();
    };
    return composer_->Compose(revision, turn.placed, reader_, progress, turn.waiting);
  } catch (const StatusError&) {
    composer_ = nullptr;  // Half done.
    return absl::CancelledError("a submap could not be read");
  } catch (...) {
    return Recover(CaughtStatus());
  }
}

std::shared_ptr<const Submap> CompositionThread::Read(const SubmapId& id) {
  const absl::Cleanup waits_no_more = [this] { activity_->NoteAwaited({}); };
  while (true) {
    try {
      return read_(id);
    } catch (const StatusError& away) {
      if (!KeepsOn()) throw;
      activity_->NoteAwaited(std::string(away.status().message()));
      ReportProblem(away.status());
    }
    // As long as it takes: a map without what cannot be read now would pass for the whole.
    map_->changed().WaitPast(map_->changed().count(), absl::Now() + kStoreAwayLook);
  }
}

// Cancelled, to go on at once, where it was thrown at a submap and there was memory.
absl::Status CompositionThread::Recover(const absl::Status& caught) {
  const std::optional<SubmapId> at_hand = composer_ ? composer_->at_hand() : std::nullopt;
  composer_ = nullptr;  // Half done.
  if (!at_hand) return caught;
  const int failures = ++failures_[*at_hand];
  if (failures == kMaxFailures) {
    const std::string problem = absl::StrCat("submap ", ToString(*at_hand),
                                             " is left out of the merged map: ", caught.message());
    activity_->NoteDamage(*at_hand, problem);
    if (on_problem_) on_problem_(problem);
    return absl::CancelledError("the rest may be composed");
  }
  // There may be memory again in a moment; and if leaving it out was no help, haste is none either.
  if (failures > kMaxFailures || absl::IsResourceExhausted(caught)) return caught;
  return absl::CancelledError("to be tried again");
}

bool CompositionThread::GivesWay() const {
  return gives_way_ && map_->view()->revision->revision != *gives_way_;
}

// While no session was removed since, and the thread is not to end.
bool CompositionThread::KeepsOn() {
  if (GivesWay()) return false;
  if (removals_ && map_->view()->removals != *removals_) return false;
  if (!stop_) return true;
  if (!since_stop_) since_stop_.emplace();
  return loading_ == nullptr && since_stop_->Ms() < kLastMapMs;
}

void CompositionThread::ReportProblem(const absl::Status& status) {
  const std::string problem(status.message());
  if (loading_ != nullptr) loading_->SetProblem(problem);
  if (std::exchange(problem_, problem) == problem || problem.empty() || !on_problem_) return;
  on_problem_("the merged map stays as it was: " + problem);
}

void CompositionThread::ReportLeftOut() {
  const composition::Composer::LeftOut left_out = composer_->left_out();
  const auto most = left_out.points > 0 ? std::optional(left_out.most) : std::nullopt;
  if (std::exchange(left_out_, most) == most || !most || !on_problem_) return;
  on_problem_(absl::StrCat(
      "the merged map leaves out ", left_out.points, " points, most of them of submap ",
      ToString(*most), ": they are scattered over more tiles than it may have. Delete the session ",
      "if they are noise; else raise composition.tile_m"));
}

void CompositionThread::Run() {
  NameThread("composition");
  LowerPriority(kCompositionNice);
  ReportNotKept(composer_->kept());
  bool goes_on = true;
  while (goes_on) {
    try {
      goes_on = RunOnce();
    } catch (...) {
      ReportProblem(CaughtStatus());
      cancelled_ = false;
      next_allowed_ = absl::Now() + absl::Seconds(kComposeAgainS);
      goes_on = !stop_;
    }
  }
  Save();
}

// So that the next start knows them in the file. Where it fails they are read once more then.
void CompositionThread::KeepContents() {
  auto contents = composer_->TakeContents();
  if (!contents.empty()) (void)map_->KeepContents(std::move(contents));
}

void CompositionThread::SaveSometimes(uint64_t removals) {
  if (absl::Now() < next_save_ && removals == saved_removals_) return;
  Save();
  next_save_ = absl::Now() + kSaveMapEvery;
  saved_removals_ = removals;
}

void CompositionThread::Save() {
  absl::Status status;
  try {
    if (composer_ != nullptr) status = composer_->Save();
  } catch (...) {
    status = CaughtStatus();
  }
  ReportNotKept(status);
}

void CompositionThread::ReportNotKept(const absl::Status& why) {
  const std::string problem(why.message());
  if (std::exchange(save_problem_, problem) == problem || problem.empty() || !on_problem_) return;
  on_problem_("the merged map is not kept for the next start: " + problem);
}

bool CompositionThread::RunOnce() {
  const uint64_t seen = map_->changed().count();
  const MapWriter::View view = map_->view();
  const bool has_lost = composer_ != nullptr && composer_->has_lost();
  if (view->IsComposed() && !has_lost) {
    if (stop_) return false;
    map_->changed().WaitPast(seen);
    return true;
  }
  if (!stop_ && absl::Now() < next_allowed_) {
    map_->changed().WaitPast(seen, next_allowed_);
    return true;
  }
  removals_ = cancelled_ ? std::nullopt : std::optional<uint64_t>(view->removals);
  std::erase_if(failures_, [&](const auto& item) {
    const SessionView* session = view->Find(item.first.session);
    return session == nullptr || !session->submaps.contains(item.first.index);
  });
  Stopwatch watch;
  const CompositionTurns::Turn turn = turns_.Next(view->PlacedSubmaps());
  if (turn.gives_way) gives_way_ = view->revision->revision;
  auto map = Compose(view->revision->revision, turn);
  if (absl::IsCancelled(map.status()) && GivesWay()) turns_.NoteGaveWay();
  gives_way_.reset();
  const double ms = watch.Ms();
  {
    MutexLock lock(&memory_mutex_);
    memory_ = composer_ == nullptr ? composition::Composer::Memory() : composer_->memory();
  }
  cancelled_ = absl::IsCancelled(map.status());
  if (!cancelled_) ReportProblem(map.status());
  double rest_s = kComposeAgainS;
  if (map.ok()) {
    // Nobody rests while somebody waits.
    rest_s = turn.waiting > 0 ? 0 : std::min(interval_s_, kRestPerWork * ms / 1e3);
    turns_.NoteShown(turn);
    ReportLeftOut();
    loading_ = nullptr;
    activity_->NoteComposition(ms);
    Show(*view, *std::move(map));
    KeepContents();
    if (turn.waiting == 0) SaveSometimes(view->removals);
  } else if (stop_) {
    return false;
  }
  if (!cancelled_) next_allowed_ = absl::Now() + absl::Seconds(rest_s);
  return true;
}

}  // namespace isthmus::server
