// The figures of a server's status, as people read them.
#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>
#include <string>

#include "core/records/server_status.h"

namespace isthmus::cli {

// "3 d 04:05:06", "00:00:12".
std::string UpTimeText(double seconds);

// The distance of one thing behind another.
struct Lag {
  uint64_t scans = 0;
  double seconds = -1;  // Since the oldest of them came; negative where that is not known.
};
Lag AckLag(const SessionLoad& session, int64_t now_ns);
Lag DurableLag(const SessionLoad& session, int64_t now_ns);
// "61 scans, 6.1 s"; "none".
std::string ToString(const Lag& lag);

}  // namespace isthmus::cli
