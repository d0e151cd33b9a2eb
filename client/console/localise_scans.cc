#include "client/console/localise_scans.h"

#include <absl/strings/str_format.h>

#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "client/console/pacer.h"
#include "client/console/say.h"
#include "core/stopwatch.h"

namespace isthmus::cli {
namespace {

// Counts the answers, and says what has changed.
class Places {
 public:
  explicit Places(const std::string& robot) : robot_(robot) {}

  void Add(int64_t stamp_ns, const LocalisedScan& scan, LocaliseSummary& summary) {
    if (summary.scans++ == 0) first_ns_ = stamp_ns;
    summary.last = scan;
    if (!scan.rejected.empty()) {
      ++summary.rejected;
      Warn("isthmus: scan %d was rejected: %s\n", scan.sequence, scan.rejected);
      return;
    }
    Count(scan.state, summary);
    odometry_ms_ += scan.odometry_ms;
    localising_ms_ += scan.localising_ms;
    if (scan.T_map_sensor) {
      summary.poses.push_back({stamp_ns, *scan.T_map_sensor});
      if (!summary.first_pose_s) {
        summary.first_pose_s = 1e-9 * static_cast<double>(stamp_ns - first_ns_);
      }
    }
    Tell(scan);
  }

  void FillMeans(LocaliseSummary& summary) const {
    if (summary.scans == summary.rejected) return;
    const double used = static_cast<double>(summary.scans - summary.rejected);
    summary.odometry_ms = odometry_ms_ / used;
    summary.localising_ms = localising_ms_ / used;
  }

 private:
  static void Count(LocalisationState state, LocaliseSummary& summary) {
    ++(state == LocalisationState::kLocated     ? summary.located
       : state == LocalisationState::kUncertain ? summary.uncertain
       : state == LocalisationState::kAmbiguous ? summary.ambiguous
                                                : summary.searching);
  }

  void Tell(const LocalisedScan& scan) {
    if (told_ && *told_ == scan.state) return;
    told_ = scan.state;
    const std::string where =
        scan.T_map_sensor
            ? absl::StrFormat(" at x %.2f y %.2f z %.2f m", scan.T_map_sensor->translation().x(),
                              scan.T_map_sensor->translation().y(),
                              scan.T_map_sensor->translation().z())
            : "";
    Warn("isthmus: %s: %s from scan %d on%s\n", robot_, ToString(scan.state), scan.sequence, where);
  }

  const std::string robot_;
  int64_t first_ns_ = 0;
  double odometry_ms_ = 0, localising_ms_ = 0;  // Sums.
  std::optional<LocalisationState> told_;
};

}  // namespace

absl::StatusOr<LocaliseSummary> LocaliseRobot(client::Client& client, RobotScans robot,
                                              const std::string& in_map_of,
                                              const PushOptions& options, PushControl& control) {
  std::vector<RobotScans> robots;
  robots.push_back(std::move(robot));
  const PushControl::Registration registered(control, &robots);
  const RobotScans& one = robots.front();
  LocalisationRequest request;
  request.sensor = one.sensor;
  request.T_base_sensor = one.T_base_sensor.value_or(Pose());
  request.odometry = options.session.odometry;
  request.robot = RobotId(one.robot);
  request.in_map_of = RobotId(in_map_of);
  const auto localisation =
      client.OpenLocalisation(request, {.resolution_m = options.resolution_m});
  LocaliseSummary summary;
  summary.robot = one.robot;
  summary.sensor = one.sensor;
  Places places(one.robot);
  Pacer pacer(options.pace_hz);
  const Stopwatch watch;
  while (!control.stopped()) {
    auto scan = one.reader->Next();
    if (!scan.ok()) {
      ++summary.unreadable;
      Warn("isthmus: left out %s\n", std::string(scan.status().message()));
      continue;
    }
    if (!scan->has_value()) break;
    pacer.Wait();
    const int64_t stamp_ns = (*scan)->end_stamp_ns;
    const auto located = localisation->Locate(stamp_ns, std::move((*scan)->payload));
    if (!located.ok()) return located.status();
    places.Add(stamp_ns, *located, summary);
  }
  summary.is_interrupted = control.stopped();
  summary.seconds = watch.Ms() / 1000;
  places.FillMeans(summary);
  return summary;
}

}  // namespace isthmus::cli
