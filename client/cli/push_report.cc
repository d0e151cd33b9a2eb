#include "client/cli/push_report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include "api/convert/session.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/say.h"
#include "client/console/tracking_text.h"
#include "core/formats/tum.h"

namespace isthmus::cli {
namespace {

Json SummaryJson(const PushSummary& summary) {
  const SessionStatus* const state = summary.has_state ? &summary.state : nullptr;
  const bool has_acks = !summary.acks.empty();
  return {{"session", summary.session.empty() ? Json(nullptr) : Json(summary.session.value())},
          {"robot", summary.robot},
          {"sensor", summary.sensor},
          {"pushed", summary.scans.pushed},
          {"processed", summary.scans.processed},
          {"rejected", summary.scans.rejected},
          {"skipped", summary.scans.skipped},
          {"before", summary.before},
          {"duplicates", summary.scans.duplicates},
          {"unreadable", summary.unreadable},
          {"durable_sequence", OrNull(summary.durable_sequence)},
          {"scans", state ? ToJson(convert::ToMessage(state->scans)) : Json(nullptr)},
          {"lost", has_acks ? Json(LossOf(summary.acks, 1).lost) : Json(nullptr)},
          {"segments", state ? Json(state->segments) : Json(nullptr)},
          {"odometry_ms_mean", OrNull(summary.mean_ms)},
          {"seconds", summary.seconds},
          {"sent_bytes", summary.scans.sent_bytes},
          {"reconnects", OrNull(summary.reconnects)},
          {"interrupted", summary.is_interrupted},
          {"assumptions", summary.assumptions}};
}

void PrintText(const PushSummary& summary) {
  if (summary.before > 0) Say("continued after scan %d\n", summary.before);
  Say("%s: %d scans processed, %d rejected, %d duplicates, %d unreadable%s%s; %.1f s\n",
      summary.session.empty() ? summary.robot : summary.session.value(), summary.scans.processed,
      summary.scans.rejected, summary.scans.duplicates, summary.unreadable,
      summary.mean_ms ? absl::StrFormat("; odometry %.1f ms per scan", *summary.mean_ms) : "",
      summary.durable_sequence ? absl::StrCat("; durable up to scan ", *summary.durable_sequence)
                               : "",
      summary.seconds);
  if (summary.state.record.id.empty()) return;  // The server was not asked.
  Say("%s: %s%s\n", summary.session.value(), CountsText(summary.state.scans),
      SegmentAndLossText(summary.state));
  const Loss loss = LossOf(summary.acks, summary.state.segments);
  if (loss.IsMuch()) Say("%s: %s\n", summary.session.value(), ToString(loss));
}

// The robot's anchors; null if it has none.
const GnssSummary* AnchorsOf(const std::string& robot, const std::vector<GnssSummary>& anchored) {
  for (const GnssSummary& gnss : anchored) {
    if (gnss.robot == robot) return &gnss;
  }
  return nullptr;
}

Json GnssJson(const GnssSummary* gnss) {
  if (gnss == nullptr) return nullptr;
  return {{"topic", gnss->topic},       {"fixes", gnss->fixes}, {"submaps", gnss->submaps},
          {"anchored", gnss->anchored}, {"wild", gnss->wild},   {"sets_datum", gnss->is_new_datum}};
}

void PrintText(const GnssSummary& gnss) {
  Say("%s: %d of %d submaps anchored by the %d fixes of %s\n", gnss.robot, gnss.anchored,
      gnss.submaps, gnss.fixes, gnss.topic);
  if (gnss.wild > 0) {
    Say("%s: %d submaps are not anchored: their fixes are far from the trajectory\n", gnss.robot,
        gnss.wild);
  }
  if (!gnss.is_new_datum) return;
  Say("%s: the first fix became the site's datum: latitude %.9f, longitude %.9f, %.3f m\n",
      gnss.robot, gnss.datum.latitude_deg, gnss.datum.longitude_deg, gnss.datum.altitude_m);
}

Json PlacesJson(const LocaliseSummary& summary) {
  const LocalisedScan* const last = summary.scans > 0 ? &summary.last : nullptr;
  const bool has_place = last != nullptr && last->T_map_sensor;
  return {{"robot", summary.robot},
          {"sensor", summary.sensor},
          {"scans", summary.scans},
          {"located", summary.located},
          {"uncertain", summary.uncertain},
          {"ambiguous", summary.ambiguous},
          {"searching", summary.searching},
          {"rejected", summary.rejected},
          {"unreadable", summary.unreadable},
          {"first_pose_s", OrNull(summary.first_pose_s)},
          {"state", last ? Json(ToString(last->state)) : Json(nullptr)},
          {"T_map_sensor", has_place ? ToJson(*last->T_map_sensor) : Json(nullptr)},
          {"component", has_place ? Json(last->component) : Json(nullptr)},
          {"revision", last ? Json(last->revision) : Json(nullptr)},
          {"odometry_ms_mean", OrNull(summary.odometry_ms)},
          {"localising_ms_mean", OrNull(summary.localising_ms)},
          {"seconds", summary.seconds},
          {"interrupted", summary.is_interrupted}};
}

void PrintText(const LocaliseSummary& summary) {
  Say("%s: of %d scans %d located, %d uncertain, %d ambiguous, %d searching, %d rejected, %d "
      "unreadable; %s",
      summary.robot, summary.scans, summary.located, summary.uncertain, summary.ambiguous,
      summary.searching, summary.rejected, summary.unreadable,
      summary.first_pose_s ? absl::StrFormat("first pose after %.1f s", *summary.first_pose_s)
                           : "no pose");
  if (summary.odometry_ms && summary.localising_ms) {
    Say("; odometry %.1f ms and localising %.1f ms per scan", *summary.odometry_ms,
        *summary.localising_ms);
  }
  Say("\n");
}

}  // namespace

int ReportPush(const std::vector<PushSummary>& summaries, const std::vector<GnssSummary>& anchored,
               const PushReportOptions& options) {
  if (options.json) {
    Json robots = Json::array();
    for (const PushSummary& summary : summaries) {
      robots.push_back(SummaryJson(summary));
      robots.back()["gnss"] = GnssJson(AnchorsOf(summary.robot, anchored));
    }
    Print(summaries.size() == 1 ? robots[0] : Json{{"robots", std::move(robots)}});
  }
  int code = kOk;
  for (const PushSummary& summary : summaries) {
    if (!options.json) {
      PrintText(summary);
      const GnssSummary* gnss = AnchorsOf(summary.robot, anchored);
      if (gnss != nullptr) PrintText(*gnss);
    }
    if (summary.is_interrupted) {
      Warn("isthmus: %s: interrupted; %s\n", summary.robot,
           !options.spool.empty()
               ? absl::StrCat("the spool keeps the scans that the server lacks, ",
                              summary.scans.backlog, " scans: the same command continues")
           : options.finish ? "the session is finished with the pushed scans"
                            : "the session is open");
      if (code == kOk) code = kInterrupted;
    } else if (summary.used() == 0) {
      code = FailInput(absl::InvalidArgumentError(absl::StrCat(
          "none of the ", summary.acks.size() + summary.unreadable, " scans could be used",
          summary.first_rejection.empty() ? "" : ": ", summary.first_rejection)));
    }
  }
  return code;
}

int ReportPlaces(const LocaliseSummary& summary, const PushReportOptions& options) {
  if (!options.poses.empty()) {
    const absl::Status written = formats::WriteTum(options.poses, summary.poses);
    if (!written.ok()) return Fail(kFailed, written);
  }
  if (options.json) {
    Print(PlacesJson(summary));
  } else {
    PrintText(summary);
  }
  if (summary.is_interrupted) return kInterrupted;
  if (summary.scans == summary.rejected) {
    return FailInput(absl::InvalidArgumentError("none of the scans could be used"));
  }
  return summary.poses.empty() ? kNoAnswer : kOk;
}

}  // namespace isthmus::cli
