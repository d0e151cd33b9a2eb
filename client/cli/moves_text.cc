#include "client/cli/moves_text.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/time/time.h>

#include <numbers>

#include "client/console/pose_text.h"
#include "client/console/say.h"

namespace isthmus::cli {

std::optional<MoveSize> SizeOf(const SubmapMove& move) {
  if (!move.before || !move.after || move.frame_before != move.frame_after) return std::nullopt;
  const Pose turned = move.before->Inverse() * *move.after;
  return MoveSize{(move.after->translation() - move.before->translation()).norm(),
                  RotationAngle(turned) * 180 / std::numbers::pi};
}

std::string TimeText(int64_t stamp_ns) {
  return absl::FormatTime("%Y-%m-%d %H:%M:%S", absl::FromUnixNanos(stamp_ns), absl::UTCTimeZone());
}

std::string RevisionHeader() {
  return absl::StrFormat("%8s  %-19s  %5s %5s %7s %12s  %s\n", "revision", "time (UTC)", "added",
                         "moved", "removed", "largest move", "cause");
}

std::string RevisionLine(const RevisionInfo& revision) {
  return LineText("%8d  %-19s  %5d %5d %7d %10.3f m  %s\n", revision.revision,
                  TimeText(revision.stamp_ns), revision.added, revision.moved, revision.removed,
                  revision.largest_move_m, revision.cause);
}

std::string MoveLine(const SubmapMove& move) {
  std::string what;
  if (const auto size = SizeOf(move)) {
    what = absl::StrFormat("moved by %.3f m, %.2f deg", size->metres, size->degrees);
  } else if (!move.before && move.after) {
    what = absl::StrCat("came, in the frame of ", move.frame_after.value(), ": ",
                        PoseText(*move.after));
  } else if (!move.after) {
    what = absl::StrCat("went, from the frame of ", move.frame_before.value());
  } else {
    what = absl::StrCat("from the frame of ", move.frame_before.value(), " to that of ",
                        move.frame_after.value(), ": ", PoseText(*move.after));
  }
  return LineText("%s: %s\n", ToString(move.submap), what);
}

}  // namespace isthmus::cli
