// Robots that send small scans at a steady rate and note how soon each is acknowledged.
#pragma once

#include <vector>

#include "core/scan_upload.h"
#include "server/pipeline.h"

namespace isthmus::bench {

struct FleetOptions {
  int robots = 8;
  int scans = 600;      // Per robot.
  double rate_hz = 10;  // Per robot.
};

class Fleet {
 public:
  // Simulates the scans, thinned to some thousand points, and opens the robots' sessions.
  Fleet(const FleetOptions& options, server::Pipeline* pipeline);

  // Each robot sends its next `scans`; returns when all are acknowledged. Milliseconds from
  // handing a scan over to its acknowledgement, sorted.
  std::vector<double> Drive(int scans);

  double odometry_ms() const;  // Mean of a scan.
  double tracked() const;      // Share of scans that were followed.

 private:
  const FleetOptions options_;
  server::Pipeline* const pipeline_;
  std::vector<std::vector<ScanUpload>> drives_;  // Shared by robots in turn.
  std::vector<SessionId> sessions_;
  int sent_ = 0;  // By each robot.
};

}  // namespace isthmus::bench
