// A run of the load generator: robots, readers and misbehaving clients at one server, all at the
// same time.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lab/loadgen/drives.h"
#include "lab/loadgen/link_profile.h"
#include "lab/loadgen/load_readers.h"
#include "lab/loadgen/load_robot.h"
#include "lab/loadgen/misbehaving_clients.h"
#include "lab/loadgen/server_process.h"

namespace isthmus::loadgen {

struct LoadOptions {
  std::string server = "localhost:50051";
  int robots = 4;
  double seconds = 60;
  double rate_hz = 10;
  double jitter_s = 0.01;
  LinkProfile link;
  WhenBehind when_behind = WhenBehind::kWait;
  int readers = 0;
  double reader_period_s = 0.2;
  int idle = 0;
  // Robots beside them whose figures stand apart: with scans of `dense_points`, with drives sent as
  // fast as the server takes them, and sessions in which nothing comes.
  int dense = 0, dense_points = 3'900'000, backfill = 0, empty = 0;
  double knocks_per_s = 0;
  MisbehavingClientOptions misbehaving;
  int server_pid = 0;           // 0: not watched.
  std::string data_folder;      // The server's; empty: not watched.
  std::string prefix = "load";  // The robots' names begin with it.
  uint64_t seed = 1;
};

// The server as it was seen once a second.
struct ServerUse {
  double at_s = 0;
  ProcessUse use;
};

struct LoadResult {
  double seconds = 0;  // Length of the run, finishing included.
  double generator_cpu_s = 0;
  std::vector<RobotResult> robots;
  std::vector<RobotResult> beside;             // Dense ones and back-fill.
  std::map<std::string, double> thread_cpu_s;  // The server's, by the names of its threads.
  std::map<std::string, ReaderResult> readers;
  std::vector<ServerUse> server;  // Empty when it was not watched.
  double disk_mb = 0;             // Growth of the data folder.
  int64_t knocks = 0, knocks_refused = 0;
  MisbehavingClientResult misbehaving;
};

// Seconds of drive that such a run needs of each of so many drives.
double DriveSeconds(const LoadOptions& options, size_t drives);

// Returns when all robots have finished their sessions. Errors of single robots are in their
// results; an error of its own: the server is not there, or is not the process that was named.
// `tick`, once a second, is told the scans acknowledged so far; false ends the run.
absl::StatusOr<LoadResult> RunLoad(const LoadOptions& options, const Drives& drives,
                                   const std::function<bool(uint64_t acknowledged)>& tick);

}  // namespace isthmus::loadgen
