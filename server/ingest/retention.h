// The rules of retention: which parts of robots' sessions are deleted, and which robots may add no
// more.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/ids.h"
#include "server/retention_options.h"

namespace isthmus::ingest {

struct StoredSession {
  SessionId session;
  RobotId robot;
  bool is_finished = false;
  int64_t created_ns = 0;
  int64_t finished_ns = 0;  // Set for a finished one only.
  uint64_t map_bytes = 0;   // Submaps and features.
  uint64_t scan_bytes = 0;  // Raw scans.
};

struct RetentionAction {
  enum class Kind { kDropScans, kDeleteSession };
  Kind kind = Kind::kDeleteSession;
  SessionId session = {};
  uint64_t bytes = 0;  // Bytes of scans: at least so many, the oldest first.
  std::string why = {};
};

struct RetentionPlan {
  std::vector<RetentionAction> actions;  // In the order in which they are to be done.
  // Robots that stay above their quota when all that is done, and what to tell them.
  std::map<RobotId, std::string> refused;
  std::string all_refused = {};  // The text for all robots; empty: the total quota refuses none.
};

// The quota of all robots together is looked at once nothing is due by the robots' own.
//
// Sessions that are not finished are never touched. Among a robot's finished ones the one that
// finished first is the oldest. Raw scans go before maps, all of them if need be; a session that
// goes for its age takes its scans with it.
RetentionPlan PlanRetention(const std::vector<StoredSession>& sessions,
                            const server::RetentionOptions& options, int64_t now_ns);

}  // namespace isthmus::ingest
