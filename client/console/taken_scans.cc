#include "client/console/taken_scans.h"

#include <memory>

namespace isthmus::cli {

TakenScans::TakenScans(const RobotScans& robot, const client::SpoolState& spool,
                       const std::function<bool()>& stopped) {
  if (spool.last_sequence == 0) return;
  last_stamp_ns_ = spool.last_stamp_ns;
  if (robot.read_again == nullptr) return;
  const auto reader = robot.read_again();
  if (!reader.ok()) return;
  for (uint64_t scans = 0; !stopped();) {
    const auto scan = (*reader)->Next();
    if (!scan.ok()) continue;
    if (!scan->has_value()) return;
    if (++scans < spool.last_sequence || (*scan)->end_stamp_ns != spool.last_stamp_ns) continue;
    count_ = scans;
    last_stamp_ns_ = 0;
    return;
  }
}

bool TakenScans::Take(int64_t end_stamp_ns) {
  if (next_++ < count_) return true;
  if (last_stamp_ns_ == 0 || end_stamp_ns > last_stamp_ns_) return false;
  ++by_stamp_;
  return true;
}

}  // namespace isthmus::cli
