#include "client/console/server_figures.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>

namespace isthmus::cli {
namespace {

Lag LagOf(uint64_t received, uint64_t done, int64_t oldest_ns, int64_t now_ns) {
  if (done >= received) return {0, 0};
  if (oldest_ns == 0) return {received - done, -1};
  // The server's clock may have been set since.
  return {received - done, std::max(0.0, 1e-9 * static_cast<double>(now_ns - oldest_ns))};
}

}  // namespace

std::string UpTimeText(double seconds) {
  const auto whole = static_cast<int64_t>(std::clamp(seconds, 0.0, 1e12));
  const int64_t days = whole / 86'400;
  const std::string time =
      absl::StrFormat("%02d:%02d:%02d", whole / 3600 % 24, whole / 60 % 60, whole % 60);
  return days > 0 ? absl::StrCat(days, " d ", time) : time;
}

Lag AckLag(const SessionLoad& session, int64_t now_ns) {
  return LagOf(session.received_sequence, session.acknowledged_sequence,
               session.oldest_unacknowledged_ns, now_ns);
}

Lag DurableLag(const SessionLoad& session, int64_t now_ns) {
  return LagOf(session.received_sequence, session.durable_sequence, session.oldest_undurable_ns,
               now_ns);
}

std::string ToString(const Lag& lag) {
  if (lag.scans == 0) return "none";
  const std::string scans = absl::StrCat(lag.scans, lag.scans == 1 ? " scan" : " scans");
  return lag.seconds < 0 ? scans : absl::StrFormat("%s, %.1f s", scans, lag.seconds);
}

}  // namespace isthmus::cli
