#include "server/threads/follower_thread.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include <algorithm>
#include <utility>

#include "core/caught.h"
#include "core/concurrency/thread_role.h"
#include "server/threads/limits.h"

namespace isthmus::server {
namespace {

bool HasChanges(const storage::StoreDelta& delta) {
  return delta.sessions || !delta.submaps.empty() || delta.remaining || !delta.trajectory.empty() ||
         delta.matches || delta.manual_decisions || delta.loops || delta.anchors || delta.datum ||
         delta.revision;
}

}  // namespace

FollowerThread::FollowerThread(std::unique_ptr<storage::MapFollower> follower, MapWriter* map,
                               EventJournal* events, const Clock* clock, OnProblem on_problem)
    : follower_(std::move(follower)),
      map_(map),
      events_(events),
      clock_(clock),
      on_problem_(on_problem ? std::move(on_problem) : [](const std::string&) {}) {}

FollowerThread::~FollowerThread() {
  Stop();
  if (thread_.joinable()) thread_.join();
}

absl::Status FollowerThread::Start() {
  if (absl::Status status = Look(); !status.ok()) return status;
  thread_ = std::thread([this] { Run(); });
  return absl::OkStatus();
}

void FollowerThread::Stop() {
  MutexLock lock(&mutex_);
  stop_ = true;
  changed_.SignalAll();
}

void FollowerThread::WaitUntilLooked() {
  MutexLock lock(&mutex_);
  const uint64_t mine = ++wanted_;
  changed_.SignalAll();
  while (!stop_ && looked_ < mine) changed_.Wait(&mutex_);
}

ReplicaState FollowerThread::state() const {
  MutexLock lock(&mutex_);
  const auto behind_ns = std::max<int64_t>(0, clock_->NowNs() - seen_ns_);
  return {owner_, 1e-9 * static_cast<double>(behind_ns), problem_};
}

absl::Status FollowerThread::Look() {
  const int64_t begun_ns = clock_->NowNs();
  const absl::StatusOr<storage::StoreDelta> delta = follower_->Next();
  if (!delta.ok()) return delta.status();
  if (HasChanges(*delta)) map_->ShowDelta(*delta);
  if (delta->has_events) events_->Wake();
  MutexLock lock(&mutex_);
  owner_ = delta->owner;
  seen_ns_ = begun_ns;
  return absl::OkStatus();
}

void FollowerThread::Note(const absl::Status& status) {
  const std::string problem =
      status.ok() ? ""
                  : absl::StrCat("the map is not followed, and stays as it is: ", status.message());
  bool was_failing = false;
  {
    MutexLock lock(&mutex_);
    was_failing = !std::exchange(problem_, problem).empty();
  }
  if (!problem.empty() && !was_failing) on_problem_(problem);
  if (problem.empty() && was_failing) on_problem_("the map is followed again");
}

void FollowerThread::Run() {
  NameThread("follower");
  while (true) {
    uint64_t wanted = 0;
    {
      MutexLock lock(&mutex_);
      const absl::Time due = absl::Now() + kFollowInterval;
      while (!stop_ && looked_ == wanted_ && !changed_.WaitWithDeadline(&mutex_, due)) {
      }
      if (stop_) return;
      wanted = wanted_;
    }
    absl::Status status;
    try {
      status = Look();
    } catch (...) {
      status = CaughtStatus();
    }
    Note(status);
    MutexLock lock(&mutex_);
    looked_ = wanted;
    changed_.SignalAll();
  }
}

}  // namespace isthmus::server
