#include "client/cli/session_list.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <string>
#include <utility>

#include "api/convert/map_changes.h"
#include "api/convert/session.h"
#include "client/console/json.h"
#include "client/console/localising_text.h"
#include "client/console/say.h"
#include "client/console/tracking_text.h"

namespace isthmus::cli {
namespace {

// The first segment shows it for all; a server that started since has processed none.
std::string MsText(const SessionStatus& session) {
  if (session.record.segment > 1) return "";
  return session.scans_processed == 0 ? "-" : absl::StrFormat("%.1f", session.odometry_ms_mean);
}

void PrintTable(const std::vector<SessionStatus>& sessions) {
  Say("%-16s %-16s %-8s %-8s %7s %7s %10s %9s %5s  %-10s %s\n", "robot", "session", "sensor",
      "state", "scans", "submaps", "points", "metres", "ms", "map", "tracking");
  for (const SessionStatus& session : sessions) {
    const std::string component =
        session.component ? absl::StrFormat("%d", *session.component) : std::string("not placed");
    // Counts over all segments are shown with the first.
    const bool is_first = session.record.segment <= 1;
    const std::string tracking = is_first
                                     ? CountsText(session.scans) + SegmentAndLossText(session)
                                     : absl::StrFormat("segment %d of %s", session.record.segment,
                                                       session.record.first_segment.value());
    Say("%-16s %-16s %-8s %-8s %7s %7d %10d %9s %5s  %-10s %s\n", session.record.robot.value(),
        session.record.id.value(), session.record.sensor,
        session.record.state == SessionState::kFinished ? "finished" : "active",
        is_first ? absl::StrCat(session.last_sequence) : "", session.submap_count,
        session.point_count, is_first ? absl::StrFormat("%.1f", session.travelled_m) : "",
        MsText(session), component, tracking);
  }
}

}  // namespace

void PrintSessions(const std::vector<SessionStatus>& sessions, bool as_json,
                   const std::optional<ServerLoad>& load) {
  if (!as_json) {
    PrintTable(sessions);
    if (!load) return;
    for (const RobotPlace& place : load->localising) {
      Say("%-16s %s\n", NameOf(place), LocalisingText(place, load->now_ns));
    }
    return;
  }
  v1::ListSessionsResponse response;
  for (const SessionStatus& session : sessions) {
    *response.add_sessions() = convert::ToMessage(session);
  }
  Json out = ToJson(response);
  if (load) {
    out["localising"] = Json::array();
    for (const RobotPlace& place : load->localising) {
      out["localising"].push_back(ToJson(convert::ToMessage(place)));
    }
  }
  Print(out);
}

}  // namespace isthmus::cli
