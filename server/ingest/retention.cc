#include "server/ingest/retention.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <tuple>

namespace isthmus::ingest {
namespace {

using Kind = RetentionAction::Kind;

std::string Megabytes(uint64_t bytes) {
  return absl::StrFormat("%.1f MB", static_cast<double>(bytes) / 1e6);
}

bool IsTooOld(const StoredSession& session, const server::RetentionLimits& limits, int64_t now_ns) {
  if (!session.is_finished || limits.max_age_days <= 0) return false;
  constexpr double kNsPerDay = 86'400e9;
  // Also where the clock was set back: then nothing is too old.
  return static_cast<double>(now_ns) - static_cast<double>(session.finished_ns) >
         limits.max_age_days * kNsPerDay;
}

bool IsOlder(const StoredSession* a, const StoredSession* b) {
  return std::tie(a->finished_ns, a->created_ns, a->session) <
         std::tie(b->finished_ns, b->created_ns, b->session);
}

// One robot's sessions; takes those that go for their age out of `stored`.
void PlanAges(const server::RetentionLimits& limits, int64_t now_ns,
              std::vector<const StoredSession*>& stored, RetentionPlan& plan) {
  std::erase_if(stored, [&](const StoredSession* session) {
    if (!IsTooOld(*session, limits, now_ns)) return false;
    plan.actions.push_back(
        {Kind::kDeleteSession, session->session, 0,
         absl::StrFormat("finished more than %g days ago", limits.max_age_days)});
    return true;
  });
}

// Returns the bytes that are still too many when all was done.
uint64_t DropOldest(const std::vector<const StoredSession*>& finished, uint64_t excess,
                    const std::string& why, RetentionPlan& plan) {
  for (const StoredSession* session : finished) {
    const uint64_t bytes = std::min(excess, session->scan_bytes);
    if (bytes == 0) continue;
    plan.actions.push_back({Kind::kDropScans, session->session, bytes, why});
    excess -= bytes;
  }
  for (const StoredSession* session : finished) {
    if (excess == 0) break;
    // Its scans went already.
    if (session->map_bytes == 0) continue;
    plan.actions.push_back({Kind::kDeleteSession, session->session, 0, why});
    excess -= std::min(excess, session->map_bytes);
  }
  return excess;
}

void PlanQuota(const RobotId& robot, const server::RetentionOptions& options,
               const std::vector<const StoredSession*>& stored, RetentionPlan& plan) {
  const uint64_t quota = options.LimitsOf(robot).quota_bytes;
  uint64_t total = 0;
  for (const StoredSession* session : stored) total += session->map_bytes + session->scan_bytes;
  if (quota == 0 || total <= quota) return;
  uint64_t excess = total - quota;
  if (options.over_quota == server::OverQuota::kDropOldest) {
    std::vector<const StoredSession*> finished;
    for (const StoredSession* session : stored) {
      if (session->is_finished) finished.push_back(session);
    }
    const std::string why = absl::StrCat("robot ", robot.value(), " has ", Megabytes(total),
                                         " stored, more than its quota of ", Megabytes(quota));
    excess = DropOldest(finished, excess, why, plan);
  }
  if (excess == 0) return;
  plan.refused[robot] = absl::StrCat(
      "robot ", robot.value(), " has ", Megabytes(total), " stored, more than its quota of ",
      Megabytes(quota), ": delete sessions of it or raise retention.quota_bytes, then send again");
}

// Plans for the quota of all robots together.
void PlanTotal(const std::vector<StoredSession>& sessions, const server::RetentionOptions& options,
               RetentionPlan& plan) {
  uint64_t total = 0;
  std::vector<const StoredSession*> finished;
  for (const StoredSession& session : sessions) {
    total += session.map_bytes + session.scan_bytes;
    if (session.is_finished) finished.push_back(&session);
  }
  const uint64_t quota = options.total_quota_bytes;
  if (quota == 0 || total <= quota) return;
  const std::string what = absl::StrCat("all robots together have ", Megabytes(total),
                                        " stored, more than the quota of ", Megabytes(quota));
  uint64_t excess = total - quota;
  if (options.over_quota == server::OverQuota::kDropOldest) {
    std::sort(finished.begin(), finished.end(), IsOlder);
    excess = DropOldest(finished, excess, what, plan);
  }
  if (excess == 0) return;
  plan.all_refused =
      absl::StrCat(what, ": delete sessions or raise retention.total_quota_bytes, then send again");
}

}  // namespace

RetentionPlan PlanRetention(const std::vector<StoredSession>& sessions,
                            const server::RetentionOptions& options, int64_t now_ns) {
  std::map<RobotId, std::vector<const StoredSession*>> by_robot;
  for (const StoredSession& session : sessions) by_robot[session.robot].push_back(&session);
  RetentionPlan plan;
  for (auto& [robot, stored] : by_robot) {
    std::sort(stored.begin(), stored.end(), IsOlder);
    PlanAges(options.LimitsOf(robot), now_ns, stored, plan);
    PlanQuota(robot, options, stored, plan);
  }
  if (plan.actions.empty()) PlanTotal(sessions, options, plan);
  return plan;
}

}  // namespace isthmus::ingest
