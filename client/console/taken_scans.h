// The scans of a recording that an earlier push has taken into its spool.
#pragma once

#include <cstdint>
#include <functional>

#include "client/console/recording_options.h"
#include "client/library/stream/scan_stream.h"

namespace isthmus::cli {

// Stamps may go back or come again where a clock was set, so that they alone do not tell. Not
// thread safe.
class TakenScans {
 public:
  // Reads the robot's recording up to the scan that the spool took last: the first with its stamp
  // that has as many before it as the spool took. Where there is none, as `--from` and `--to` name
  // another part or the recording is another, or it cannot be read again, those that are not
  // later were taken. Gives up once `stopped` says so.
  TakenScans(const RobotScans& robot, const client::SpoolState& spool,
             const std::function<bool()>& stopped);

  // True where the next scan of the recording was taken.
  bool Take(int64_t end_stamp_ns);
  // Scans that were taken to be so by their stamps alone.
  uint64_t by_stamp() const { return by_stamp_; }

 private:
  uint64_t count_ = 0;         // Of the first scans of the recording.
  int64_t last_stamp_ns_ = 0;  // Not 0: up to it they were.
  uint64_t next_ = 0, by_stamp_ = 0;
};

}  // namespace isthmus::cli
