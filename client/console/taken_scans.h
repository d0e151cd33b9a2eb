// The scans of a recording that an earlier push has taken into its spool.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <functional>
#include <optional>

#include "client/console/recording_options.h"
#include "client/library/stream/scan_stream.h"

namespace isthmus::cli {

// The end of a session at the server, as far as its poses tell.
struct ServerEnd {
  int64_t stamp_ns = 0;   // END of the newest scan with a pose.
  uint64_t poseless = 0;  // At most so many scans behind it have none.
  uint64_t late = 0;      // So many came since the spool was opened.
};

// Stamps may go back or come again where a clock was set, and recordings without times all have the
// same ones, so that stamps alone do not tell. Not thread safe.
class TakenScans {
 public:
  // True for the scan that the spool took last; nothing where that is not known.
  using IsLast = std::function<std::optional<bool>(const readers::RecordedScan& scan)>;

  // Reads the robot's recording up to the scan that the spool took last: the first with its stamp
  // and content that has as many before it as the spool took, else the first with them. Where its
  // content is not known any more the first with its stamp that has as many before it. Where the
  // server's last scan is another it reads up to that one too, of which `end` is known maybe. Gives
  // up once `stopped` says so.
  TakenScans(const RobotScans& robot, const client::SpoolState& spool, const IsLast& is_last,
             const std::function<bool()>& stopped,
             const std::optional<ServerEnd>& end = std::nullopt);

  // FailedPrecondition where the recording was read, and is another: it has not the spool's last
  // scan, and not only later ones, or not the server's last where it should.
  const absl::Status& status() const { return status_; }

  // True where the next scan of the recording was taken.
  bool Take(int64_t end_stamp_ns);
  // Scans that were taken to be so by their stamps alone, as the recording cannot be read twice.
  uint64_t by_stamp() const { return by_stamp_; }

 private:
  void FindLast(const RobotScans& robot, const client::SpoolState& spool, const IsLast& is_last,
                const std::function<bool()>& stopped);
  void CompareEnd(const RobotScans& robot, const client::SpoolState& spool,
                  const std::function<bool()>& stopped, const std::optional<ServerEnd>& end);

  absl::Status status_;
  uint64_t count_ = 0;         // So many first scans of the recording were taken.
  int64_t last_stamp_ns_ = 0;  // Not 0: up to it they were.
  uint64_t next_ = 0, by_stamp_ = 0;
};

}  // namespace isthmus::cli
