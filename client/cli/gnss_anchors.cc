#include "client/cli/gnss_anchors.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <optional>
#include <utility>

#include "client/cli/anchor_import.h"

namespace isthmus::cli {
namespace {

// Of the session or a later segment of it: "alice-1", "alice-1.2".
bool IsOf(const SessionId& session, const SessionId& id) {
  return id == session || absl::StartsWith(id.value(), session.value() + ".");
}

absl::StatusOr<std::vector<SubmapInfo>> SubmapsOf(client::Client& client, const std::string& robot,
                                                  const SessionId& session) {
  const auto listed = client.ListSubmaps(RobotId(robot));
  if (!listed.ok()) return listed.status();
  std::vector<SubmapInfo> submaps;
  for (const SubmapStatus& submap : *listed) {
    if (IsOf(session, submap.info.id.session)) submaps.push_back(submap.info);
  }
  return submaps;
}

}  // namespace

absl::StatusOr<GnssSummary> AnchorByFixes(client::Client& client, const GnssOfRobot& gnss,
                                          const SessionId& session) {
  const auto submaps = SubmapsOf(client, gnss.robot, session);
  if (!submaps.ok()) return submaps.status();
  const auto info = client.GetMapInfo();
  if (!info.ok()) return info.status();
  const auto made = georeference::AnchorsOfFixes(gnss.fixes, *submaps, info->datum, gnss.antenna);
  if (!made.ok()) return made.status();
  if (made->is_new_datum && !made->anchors.empty()) {
    if (absl::Status status = client.SetDatum(made->datum); !status.ok()) return status;
  }
  const auto put = PutAnchors(client, made->anchors);
  if (!put.ok()) return put.status();
  GnssSummary summary{gnss.robot, gnss.topic, gnss.fixes.size()};
  summary.submaps = static_cast<int>(submaps->size());
  summary.anchored = put->anchored;
  summary.is_new_datum = made->is_new_datum && !made->anchors.empty();
  summary.datum = made->datum;
  return summary;
}

}  // namespace isthmus::cli
