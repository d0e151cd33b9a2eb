#include "server/pipeline/retention_loop.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

namespace isthmus::server {
namespace {

// What is dropped makes room for no other round to drop more: two suffice, and a store that cannot
// delete is not asked for ever.
constexpr int kMaxRounds = 3;

std::string TextOf(const RetentionAction& action) {
  const bool scans = action.kind == RetentionAction::Kind::kDropScans;
  return absl::StrCat(scans ? "oldest raw scans of session " : "session ", action.session.value(),
                      scans ? " dropped: " : " deleted: ", action.why);
}

}  // namespace

RetentionLoop::RetentionLoop(const RetentionOptions& options, const Clock* clock, Hooks hooks)
    : options_(options), clock_(clock), hooks_(std::move(hooks)) {}

RetentionLoop::~RetentionLoop() {
  Stop();
  if (thread_.joinable()) thread_.join();
}

void RetentionLoop::Start() {
  Round();
  thread_ = std::thread([this] { Run(); });
}

void RetentionLoop::Stop() {
  std::lock_guard lock(mutex_);
  stop_ = true;
  changed_.notify_all();
}

void RetentionLoop::Changed(const SessionId& session) {
  std::lock_guard lock(mutex_);
  stale_.insert(session);
  ++changes_;
  changed_.notify_all();
}

void RetentionLoop::WaitUntilIdle() {
  std::unique_lock lock(mutex_);
  const uint64_t wanted = changes_;
  changed_.wait(lock, [&] { return stop_ || looked_at_ >= wanted; });
}

absl::Status RetentionLoop::Check(const RobotId& robot) const {
  std::lock_guard lock(mutex_);
  const auto found = refused_.find(robot);
  if (found == refused_.end()) return absl::OkStatus();
  return absl::ResourceExhaustedError(found->second);
}

uint64_t RetentionLoop::MapBytes(const SessionId& session) const {
  std::lock_guard lock(mutex_);
  const auto found = map_bytes_.find(session);
  return found == map_bytes_.end() ? 0 : found->second;
}

void RetentionLoop::Run() {
  while (true) {
    {
      std::unique_lock lock(mutex_);
      const bool is_told =
          changed_.wait_for(lock, kInterval, [this] { return stop_ || looked_at_ < changes_; });
      if (stop_) return;
      // Matching adds features to what is stored, a while after its submaps.
      for (const auto& [session, bytes] : map_bytes_) {
        if (!is_told) stale_.insert(session);
      }
    }
    Round();
  }
}

void RetentionLoop::Round() {
  uint64_t changes = 0;
  {
    std::lock_guard lock(mutex_);
    changes = changes_;
  }
  RetentionPlan plan;
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<StoredSession> sessions = Count();
    plan = PlanRetention(sessions, options_, clock_->NowNs());
    if (!Do(plan)) break;
  }
  std::lock_guard lock(mutex_);
  refused_ = std::move(plan.refused);
  looked_at_ = std::max(looked_at_, changes);
  changed_.notify_all();
}

std::vector<StoredSession> RetentionLoop::Count() {
  std::vector<StoredSession> sessions = hooks_.list();
  std::map<SessionId, uint64_t> known;
  std::set<SessionId> stale;
  {
    std::lock_guard lock(mutex_);
    known = map_bytes_;
    stale = std::exchange(stale_, {});
  }
  std::map<SessionId, uint64_t> counted;
  for (StoredSession& session : sessions) {
    const auto before = known.find(session.session);
    session.map_bytes = before == known.end() ? 0 : before->second;
    if (before == known.end() || stale.contains(session.session)) {
      const auto bytes = hooks_.map_bytes(session.session);
      if (bytes.ok()) session.map_bytes = *bytes;
    }
    session.scan_bytes = hooks_.scan_bytes(session.session);
    counted[session.session] = session.map_bytes;
  }
  std::lock_guard lock(mutex_);
  map_bytes_ = std::move(counted);
  return sessions;
}

bool RetentionLoop::Do(const RetentionPlan& plan) {
  bool any = false;
  for (const RetentionAction& action : plan.actions) {
    {
      std::lock_guard lock(mutex_);
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
