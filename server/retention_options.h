// Options of retention: the amount of a robot's data that is kept, and the time.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "core/ids.h"

namespace isthmus::server {

// The consequence for a robot that has more stored than its quota.
enum class OverQuota {
  kRefuse,      // It can add nothing until someone makes room.
  kDropOldest,  // Raw scans of its finished sessions go, the oldest first; then such sessions. If
                // that is not enough it is refused.
};

struct RetentionLimits {
  uint64_t quota_bytes = 0;  // Submaps, features and raw scans of all its sessions; 0: no limit.
  double max_age_days = 0;   // Finished sessions go when they are older; 0: never.
};

struct RetentionOptions {
  RetentionLimits limits = {};
  // Quota of all robots together; 0: no limit. So many names with small quotas fill no disk.
  uint64_t total_quota_bytes = 0;
  OverQuota over_quota = OverQuota::kRefuse;
  // In place of `limits`, for robots of these names.
  std::map<RobotId, RetentionLimits> robots = {};

  const RetentionLimits& LimitsOf(const RobotId& robot) const {
    const auto own = robots.find(robot);
    return own == robots.end() ? limits : own->second;
  }
};

}  // namespace isthmus::server
