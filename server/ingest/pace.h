// The pace of a session's scans: sent as they are measured, or filled in from a recording.
#pragma once

#include <cstdint>

namespace isthmus::ingest {

// A robot that is live sends scans as fast as their stamps go on; one that catches up after a lost
// link, or pushes a recording, sends them faster. Not thread safe.
class Pace {
 public:
  // A scan that ended at `end_stamp_ns` by the robot's clock came at `now_ns`, by any steady clock.
  void NoteScan(int64_t end_stamp_ns, int64_t now_ns);

  // True while scans are ahead of the clock by kBackfillLead_ns or more, until they are no more.
  bool IsBackfill() const { return is_backfill_; }

 private:
  bool started_ = false;
  bool is_backfill_ = false;
  int64_t stamp_ns_ = 0, now_ns_ = 0;  // The last scan's stamp and arrival.
  int64_t lead_ns_ = 0;                // Lead of stamps over the clock, 0 to kMaxLead_ns.
};

}  // namespace isthmus::ingest
