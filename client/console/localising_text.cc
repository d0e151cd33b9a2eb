#include "client/console/localising_text.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>

#include "client/console/server_figures.h"

namespace isthmus::cli {
namespace {

double Seconds(int64_t from_ns, int64_t to_ns) {
  return std::max(0.0, 1e-9 * static_cast<double>(to_ns - from_ns));
}

}  // namespace

std::string NameOf(const RobotPlace& place) {
  return place.robot.empty() ? "(unnamed)" : place.robot.value();
}

std::string PlaceText(const RobotPlace& place) {
  if (!place.component) return "";
  const Eigen::Vector3d& at = place.T_map_sensor.translation();
  return absl::StrFormat("at %.2f, %.2f, %.2f of map %d", at.x(), at.y(), at.z(), *place.component);
}

std::string LocalisingText(const RobotPlace& place, int64_t now_ns) {
  const Localising& localising = *place.localising;
  std::string text =
      absl::StrCat("localised since ", UpTimeText(Seconds(localising.since_ns, now_ns)));
  if (localising.scans == 0) return absl::StrCat(text, ": no scans yet");
  absl::StrAppend(&text, ": ", ToString(localising.state));
  if (place.component) absl::StrAppend(&text, " ", PlaceText(place));
  const double for_s = Seconds(localising.since_ns, localising.received_ns);
  absl::StrAppend(&text, "; ", localising.scans, localising.scans == 1 ? " scan" : " scans");
  if (for_s > 0) {
    absl::StrAppendFormat(&text, ", %.1f/s", static_cast<double>(localising.scans) / for_s);
  }
  absl::StrAppendFormat(&text, ", the last %.1f s ago", Seconds(localising.received_ns, now_ns));
  return text;
}

}  // namespace isthmus::cli
