#include "client/console/taken_scans.h"

#include <absl/strings/str_cat.h>

#include <memory>

namespace isthmus::cli {

TakenScans::TakenScans(const RobotScans& robot, const client::SpoolState& spool,
                       const IsLast& is_last, const std::function<bool()>& stopped) {
  if (spool.last_sequence == 0) return;
  last_stamp_ns_ = spool.last_stamp_ns;
  if (robot.read_again == nullptr) return;
  const auto reader = robot.read_again();
  if (!reader.ok()) return;
  bool is_later = true;
  for (uint64_t scans = 0; !stopped();) {
    const auto scan = (*reader)->Next();
    if (!scan.ok()) continue;
    if (!scan->has_value()) break;
    ++scans;
    is_later = is_later && (*scan)->end_stamp_ns > spool.last_stamp_ns;
    if ((*scan)->end_stamp_ns != spool.last_stamp_ns) continue;
    const bool has_as_many_before = scans >= spool.last_sequence;
    if (!is_last(**scan).value_or(has_as_many_before)) continue;
    if (count_ == 0 || has_as_many_before) count_ = scans;
    if (has_as_many_before) break;
  }
  if (count_ > 0) last_stamp_ns_ = 0;
  if (count_ > 0 || is_later || stopped()) return;
  status_ = absl::FailedPreconditionError(
      absl::StrCat("the last of ", spool.last_sequence, " scans in the spool is not in this ",
                   "recording, so they are of another one: push that one to continue with ",
                   spool.session.empty() ? "it" : spool.session.value(),
                   ", or name another folder with --spool"));
}

bool TakenScans::Take(int64_t end_stamp_ns) {
  if (next_++ < count_) return true;
  if (last_stamp_ns_ == 0 || end_stamp_ns > last_stamp_ns_) return false;
  ++by_stamp_;
  return true;
}

}  // namespace isthmus::cli
