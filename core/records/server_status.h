// The status of a server: the process, the calls under way, what is degraded, and the load of one
// of its sites.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/records/server_load.h"

namespace isthmus {

// The process's use of the machine; zeros if the system does not tell.
struct ProcessUse {
  double cpu_s = 0;  // Time of all threads since its start, user and system.
  uint64_t resident_bytes = 0;
  uint64_t threads = 0;
  uint64_t open_files = 0, open_files_limit = 0;
};

// Calls of all sites, the call that asks included.
struct RunningCallCounts {
  uint64_t streams = 0;  // StreamScans, Localise and UploadSubmap.
  uint64_t queries = 0, exports = 0, lists = 0, others = 0;
};

// A service that health checking calls NOT_SERVING.
struct DegradedService {
  std::string service;  // "isthmus.v1.SessionService".
  std::string why;      // For people.
};

// A method that would fail for the caller whatever is asked, as things are.
struct RefusedMethod {
  std::string method;  // "DecideMatch".
  std::string why;     // For people.
};

struct ServerStatus {
  std::string version;
  std::string site;        // The site of `degraded` and `load`.
  int64_t started_ns = 0;  // When it began to serve; the server's clock.
  double uptime_s = 0;     // Since then.
  ProcessUse process;
  RunningCallCounts calls;
  std::vector<DegradedService> degraded;
  uint64_t uploads = 0;  // Submaps of the site of which some part has arrived.
  ServerLoad load;
  // "https://host:port" where browsers are served, as it listens; empty: nowhere.
  std::string web_address;
  std::vector<RefusedMethod> refused;  // In the order of their services.
};

}  // namespace isthmus
