#include "client/console/tracking_text.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>

namespace isthmus::cli {

std::string CountsText(const ScanCounts& scans) {
  std::string text = absl::StrCat(scans.ok, " ok, ", scans.degenerate, " degenerate, ", scans.lost,
                                  " lost, ", scans.rejected, " rejected");
  if (scans.skipped > 0) absl::StrAppend(&text, ", ", scans.skipped, " skipped");
  return text;
}

std::string SegmentAndLossText(const SessionStatus& session) {
  std::string text;
  if (session.segments > 1) {
    absl::StrAppend(&text, "; segment ", session.segments, " of ", session.segments);
  }
  if (session.lost_since_ns != 0) {
    absl::StrAppendFormat(&text, "; LOST since stamp %.3f",
                          1e-9 * static_cast<double>(session.lost_since_ns));
  }
  return text;
}

std::string DegeneracyText(const ScanCounts& scans) {
  const uint64_t all = scans.ok + scans.degenerate + scans.lost + scans.rejected;
  if (scans.degenerate * 2 <= all) return "";
  return absl::StrFormat(
      "in %d of %d scans (%.0f %%) a direction was not observed; along it the poses are "
      "extrapolated",
      scans.degenerate, all,
      100 * static_cast<double>(scans.degenerate) / static_cast<double>(all));
}

Loss LossOf(const std::vector<ScanAck>& acks, uint32_t segments) {
  const auto lost = std::count_if(acks.begin(), acks.end(), [](const ScanAck& ack) {
    return ack.tracking == Tracking::kLost && ack.outcome != ScanOutcome::kRejected;
  });
  return {static_cast<uint64_t>(lost), acks.size(), segments};
}

std::string ToString(const Loss& loss) {
  const double share =
      loss.scans == 0 ? 0 : static_cast<double>(loss.lost) / static_cast<double>(loss.scans);
  std::string text =
      absl::StrFormat("lost in %d of %d scans (%.0f %%)", loss.lost, loss.scans, 100 * share);
  if (loss.segments > 1) {
    absl::StrAppend(&text, ", ", loss.segments,
                    " segments; poses of different segments share no frame");
  }
  return text;
}

}  // namespace isthmus::cli
