#include "client/console/match_text.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <vector>

#include "client/console/pose_text.h"
#include "client/console/say.h"

namespace isthmus::cli {
namespace {

std::vector<std::string> Evidence(const Match& m) {
  std::vector<std::string> parts;
  if (m.confidence >= 0) parts.push_back(absl::StrFormat("confidence %.2f", m.confidence));
  if (m.overlap >= 0) parts.push_back(absl::StrFormat("overlap %.0f %%", 100 * m.overlap));
  if (m.shared_area_m2 >= 0) parts.push_back(absl::StrFormat("shared %.0f m2", m.shared_area_m2));
  if (m.inliers >= 0) parts.push_back(absl::StrFormat("inliers %d", m.inliers));
  if (m.inlier_ratio >= 0) {
    parts.push_back(absl::StrFormat("inlier ratio %.0f %%", 100 * m.inlier_ratio));
  }
  if (m.residual_m >= 0) parts.push_back(absl::StrFormat("residual %.3f m", m.residual_m));
  return parts;
}

std::vector<std::string> Checks(const Match& m) {
  std::vector<std::string> parts;
  if (m.comparisons >= 0 && m.free_space >= 0) {
    parts.push_back(absl::StrFormat("free space: %.2f %% of %d contradicted", 100 * m.free_space,
                                    m.comparisons));
  }
  if (m.runner_up >= 0) parts.push_back(absl::StrFormat("runner-up %.2f %%", 100 * m.runner_up));
  if (m.observability >= 0) parts.push_back(absl::StrFormat("observability %.3f", m.observability));
  if (m.odometry_residual >= 0)
    parts.push_back(absl::StrFormat("odometry residual %.2f", m.odometry_residual));
  if (m.cycle_m >= 0) {
    parts.push_back(absl::StrFormat("best cycle %.2f m, %.1f deg", m.cycle_m, m.cycle_deg));
  }
  return parts;
}

std::string Effort(const Match& m) {
  std::string text = m.matcher == GuessSource::kByHand
                         ? std::string("given by hand")
                         : absl::StrCat("found by ", ToString(m.matcher));
  if (m.candidates > 0) absl::StrAppend(&text, ", guesses refined: ", m.candidates);
  if (m.submaps_a > 0) {
    absl::StrAppend(&text, ", from ", m.submaps_a, " and ", m.submaps_b, " submaps");
  }
  std::vector<std::string> stages;
  for (const StageTime& stage : m.stages) {
    stages.push_back(absl::StrFormat("%s %.0f ms", stage.stage, stage.ms));
  }
  if (!stages.empty()) absl::StrAppend(&text, "; ", absl::StrJoin(stages, ", "));
  return text;
}

std::string DriveText(const RobotDrive& drive, const MatchEdge& edge) {
  const RobotId& other = drive.robot == edge.robot_a ? edge.robot_b : edge.robot_a;
  const auto place = [&](size_t point) {
    const Eigen::Vector3d& at = drive.way[std::min(point, drive.way.size() - 1)];
    return absl::StrFormat("%.1f %.1f", at.x(), at.y());
  };
  return absl::StrFormat(
      "to tell: %s drives %.0f m, leaves its own way at %s, goes where %s was, to %s; then %.0f %% "
      "probable if it is this place",
      drive.robot.value(), drive.length_m, place(drive.leaves_own), other.value(),
      place(drive.way.size()), 100 * drive.confidence);
}

void AddLine(const std::vector<std::string>& parts, std::string* text) {
  if (!parts.empty()) absl::StrAppend(text, "  ", Printable(absl::StrJoin(parts, ", ")), "\n");
}

}  // namespace

std::string MatchText(const MatchEdge& edge, const std::string& name) {
  const Match& m = edge.match;
  std::string text =
      absl::StrCat(Printable(name), ": ", ToString(m.state), ", ", ToString(m.reason),
                   edge.in_tree ? " (carries the map)" : "", "\n");
  AddLine({m.detail}, &text);
  if (m.matcher == GuessSource::kNone) return text;  // Nothing was found, so nothing was measured.
  AddLine({absl::StrCat("T_a_b: ", PoseText(m.T_a_b))}, &text);
  AddLine(Evidence(m), &text);
  AddLine(Checks(m), &text);
  AddLine({Effort(m)}, &text);
  for (const RobotDrive& drive : edge.asked_drives) {
    if (!drive.way.empty()) AddLine({DriveText(drive, edge)}, &text);
  }
  return text;
}

std::string MatchText(const MatchEdge& edge) {
  return MatchText(edge, absl::StrCat(edge.match.a.value(), " ~ ", edge.match.b.value()));
}

}  // namespace isthmus::cli
