#include "tests/faults/harness/report.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

namespace isthmus::faults {
namespace {

constexpr double kMaxRmseM = 0.01;

}  // namespace

void Report::Judge() {
  const auto none = [this](uint64_t count, const char* what) {
    if (count > 0) Break(absl::StrCat(count, " ", what));
  };
  none(lost_durable, "durable scans lost");
  none(lost_pushed, "pushed scans lost");
  none(duplicates, "scans counted twice");
  none(moved_poses, "poses other than they were told");
  none(map.missing_scans, "scans of the undisturbed map missing");
  none(map.odd_scans, "scans that the undisturbed map has not");
  none(map.repeated_scans, "scans stored twice");
  none(map.other_submaps, "submaps other than in the undisturbed map");
  if (!(map.rmse_m <= kMaxRmseM)) Break(absl::StrCat("trajectory RMSE ", map.rmse_m, " m"));
}

std::string ToMarkdown(const std::vector<Report>& reports) {
  std::string text =
      "| campaign | faults | scans | durable lost | duplicates | submaps | RMSE (m) | same bits | "
      "measured | s | verdict |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Report& report : reports) {
    absl::StrAppendFormat(
        &text, "| %s | %s | %d | %d | %d | %d of %d | %.4f | %s | %s | %.0f | %s |\n", report.name,
        report.faults, report.scans, report.lost_durable + report.lost_pushed,
        report.duplicates + report.map.repeated_scans, report.map.submaps, report.submaps_wanted,
        report.map.rmse_m, report.map.same_bits ? "yes" : "no", absl::StrJoin(report.figures, "; "),
        report.seconds,
        report.broken.empty() ? "kept"
                              : absl::StrCat("BROKEN: ", absl::StrJoin(report.broken, "; ")));
  }
  return text;
}

}  // namespace isthmus::faults
