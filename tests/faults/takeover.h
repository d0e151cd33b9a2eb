// Servers with spares that die, hang and are cut off while robots stream: the map must not suffer,
// and robots wait for a limited time.
#pragma once

#include <functional>
#include <string>

#include "tests/faults/harness/fleet.h"

namespace isthmus::faults {

struct TakeoverOptions {
  int servers = 3;
  // Processes that match for the servers, of which one is killed now and then.
  int workers = 0;
  std::string worker_program = {};
  double lease_s = 3;
  // Faults of servers: every so many seconds one is killed, or paused for longer than the lease.
  // It is the owner, or any of them.
  int faults = 12;
  double every_s = 5;
  bool always_the_owner = false, only_kills = false;
  double cut_s = 0;         // One server is cut off from PostgreSQL so long, half way; 0: none is.
  int restarts = 0;         // Restarts of PostgreSQL.
  double period_s = 0.1;    // Period of the robots' sensors.
  std::string socket = {};  // PostgreSQL's, to which the servers' links lead.
  std::function<void()> restart_database = nullptr;
};

// With the map of `setup.store`, which is empty before. The figures say how long it took until a
// robot was acknowledged again.
Report TakeOver(const Setup& setup, const TakeoverOptions& options);

}  // namespace isthmus::faults
