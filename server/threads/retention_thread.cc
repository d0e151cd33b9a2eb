#include "server/threads/retention_thread.h"

#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>

#include <algorithm>
#include <utility>

#include "core/caught.h"
#include "core/concurrency/mutex.h"
#include "core/concurrency/thread_role.h"
#include "server/threads/limits.h"

namespace isthmus::server {
namespace {

std::string TextOf(const ingest::RetentionAction& action) {
  const bool scans = action.kind == ingest::RetentionAction::Kind::kDropScans;
  return absl::StrCat(scans ? "oldest raw scans of session " : "session ", action.session.value(),
                      scans ? " dropped: " : " deleted: ", action.why);
}

}  // namespace

RetentionThread::RetentionThread(const RetentionOptions& options, const Clock* clock, Hooks hooks)
    : options_(options), clock_(clock), hooks_(std::move(hooks)) {}

RetentionThread::~RetentionThread() {
  Stop();
  if (thread_.joinable()) thread_.join();
}

void RetentionThread::Start() {
  RunRound();
  thread_ = std::thread([this] { Run(); });
}

void RetentionThread::Stop() {
  MutexLock lock(&mutex_);
  stop_ = true;
  changed_.SignalAll();
}

void RetentionThread::NoteChange(const SessionId& session) {
  MutexLock lock(&mutex_);
  stale_.insert(session);
  ++changes_;
  changed_.SignalAll();
}

void RetentionThread::WaitUntilIdle() {
  MutexLock lock(&mutex_);
  const uint64_t wanted = changes_;
  while (!stop_ && looked_at_ < wanted) changed_.Wait(&mutex_);
}

absl::Status RetentionThread::CheckQuota(const RobotId& robot) const {
  MutexLock lock(&mutex_);
  if (!all_refused_.empty()) return absl::ResourceExhaustedError(all_refused_);
  const auto found = refused_.find(robot);
  if (found == refused_.end()) return absl::OkStatus();
  return absl::ResourceExhaustedError(found->second);
}

uint64_t RetentionThread::MapBytes(const SessionId& session) const {
  MutexLock lock(&mutex_);
  const auto found = map_bytes_.find(session);
  return found == map_bytes_.end() ? 0 : found->second;
}

void RetentionThread::Run() {
  while (true) {
    {
      MutexLock lock(&mutex_);
      const absl::Time due = absl::Now() + kRetentionInterval;
      bool is_told = stop_ || looked_at_ < changes_;
      while (!is_told && !changed_.WaitWithDeadline(&mutex_, due)) {
        is_told = stop_ || looked_at_ < changes_;
      }
      if (stop_) return;
      // Matching adds features to what is stored, a while after its submaps.
      for (const auto& [session, bytes] : map_bytes_) {
        if (!is_told) stale_.insert(session);
      }
    }
    RunRound();
  }
}

void RetentionThread::RunRound() {
  uint64_t changes = 0;
  {
    MutexLock lock(&mutex_);
    changes = changes_;
  }
  try {
    CountAndDo();
  } catch (...) {
    const absl::Status caught = CaughtStatus();
    if (hooks_.on_problem) {
      hooks_.on_problem(absl::StrCat("the limits of robots' storage could not be checked: ",
                                     caught.message(), "; they are with the next change"));
    }
  }
  MutexLock lock(&mutex_);
  looked_at_ = std::max(looked_at_, changes);
  changed_.SignalAll();
}

void RetentionThread::CountAndDo() {
  ingest::RetentionPlan plan;
  for (int round = 0; round < kMaxRetentionRounds; ++round) {
    const std::vector<ingest::StoredSession> sessions = CountStored();
    plan = ingest::PlanRetention(sessions, options_, clock_->NowNs());
    if (!CarryOut(plan)) break;
  }
  MutexLock lock(&mutex_);
  refused_ = std::move(plan.refused);
  all_refused_ = std::move(plan.all_refused);
}

std::vector<ingest::StoredSession> RetentionThread::CountStored() {
  std::vector<ingest::StoredSession> sessions = hooks_.list();
  std::map<SessionId, uint64_t> known;
  std::set<SessionId> stale;
  {
    MutexLock lock(&mutex_);
    known = map_bytes_;
    stale = std::exchange(stale_, {});
  }
  std::map<SessionId, uint64_t> counted;
  for (ingest::StoredSession& session : sessions) {
    const auto before = known.find(session.session);
    session.map_bytes = before == known.end() ? 0 : before->second;
    if (before == known.end() || stale.contains(session.session)) {
      const auto bytes = hooks_.map_bytes(session.session);
      if (bytes.ok()) session.map_bytes = *bytes;
    }
    session.scan_bytes = hooks_.scan_bytes(session.session);
    counted[session.session] = session.map_bytes;
  }
  MutexLock lock(&mutex_);
  map_bytes_ = std::move(counted);
  return sessions;
}

bool RetentionThread::CarryOut(const ingest::RetentionPlan& plan) {
  bool any = false;
  for (const ingest::RetentionAction& action : plan.actions) {
    {
      MutexLock lock(&mutex_);
      if (stop_) return false;
    }
    const absl::Status status = hooks_.act(action);
    any = any || status.ok();
    if (!hooks_.on_problem) continue;
    hooks_.on_problem(
        status.ok() ? TextOf(action)
                    : absl::StrCat("could not be done, ", TextOf(action), ": ", status.message()));
  }
  return any;
}

}  // namespace isthmus::server
