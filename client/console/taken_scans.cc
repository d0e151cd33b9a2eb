#include "client/console/taken_scans.h"

#include <absl/strings/str_cat.h>

#include <memory>

namespace isthmus::cli {
namespace {

// A server counts scans a moment before it has their poses: so many at most, as its window is 16.
// More would take a recording of the same stamps for the spool's.
constexpr int64_t kPosesToCome = 16;

}  // namespace

TakenScans::TakenScans(const RobotScans& robot, const client::SpoolState& spool,
                       const IsLast& is_last, const std::function<bool()>& stopped,
                       const std::optional<ServerEnd>& end) {
  if (spool.last_sequence > 0) {
    last_stamp_ns_ = spool.last_stamp_ns;
    FindLast(robot, spool, is_last, stopped);
  }
  if (status_.ok() && spool.server_ahead) CompareEnd(robot, spool, stopped, end);
}

void TakenScans::FindLast(const RobotScans& robot, const client::SpoolState& spool,
                          const IsLast& is_last, const std::function<bool()>& stopped) {
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

void TakenScans::CompareEnd(const RobotScans& robot, const client::SpoolState& spool,
                            const std::function<bool()>& stopped,
                            const std::optional<ServerEnd>& end) {
  if (robot.read_again == nullptr) return;
  const auto reader = robot.read_again();
  if (!reader.ok()) return;
  const int64_t known = static_cast<int64_t>(count_) + *spool.server_ahead;
  const int64_t last = known + static_cast<int64_t>(end ? end->late : 0);
  int64_t scans = 0, posed = 0;
  while (scans < last && !stopped()) {
    const auto scan = (*reader)->Next();
    if (!scan.ok()) continue;
    if (!scan->has_value()) break;
    ++scans;
    if (end && (*scan)->end_stamp_ns == end->stamp_ns) posed = scans;
  }
  const bool has_begin = count_ > 0 || spool.last_sequence == 0;
  const bool has_pose =
      end && posed > 0 && posed + static_cast<int64_t>(end->poseless) + kPosesToCome >= known;
  if ((has_begin && scans == last && (!end || has_pose)) || stopped()) return;
  status_ = absl::FailedPreconditionError(absl::StrCat(
      "the spool is damaged, and the scans that the server has in ", spool.session.value(),
      " are not those of this recording: push the one that they are of, or name another folder "
      "with --spool for a session of its own"));
}

bool TakenScans::Take(int64_t end_stamp_ns) {
  if (next_++ < count_) return true;
  if (last_stamp_ns_ == 0 || end_stamp_ns > last_stamp_ns_) return false;
  ++by_stamp_;
  return true;
}

}  // namespace isthmus::cli
