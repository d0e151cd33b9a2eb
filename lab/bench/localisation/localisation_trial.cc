#include "lab/bench/localisation/localisation_trial.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "client/evaluation/trajectory_error.h"
#include "core/stopwatch.h"
#include "floam/localise/localiser.h"
#include "floam/rings/sensor_model.h"

namespace isthmus::bench {
namespace {

constexpr double kNearM = 5;    // A start so near the map's way sees what the map shows.
constexpr double kStartS = 20;  // A start is followed for so long.

evaluation::TrajectoryPair WayOf(const DrivenRobot& robot) {
  evaluation::TrajectoryPair pair;
  pair.name = robot.session.id.value();
  for (const ScanPose& pose : robot.poses) {
    pair.truth.push_back({pose.stamp_ns, pose.T_world_sensor});
    pair.estimate.push_back({pose.stamp_ns, pose.T_odom_sensor});
  }
  return pair;
}

struct Sums {
  double odometry_ms = 0, localising_ms = 0;
  int followed = 0;
};

absl::Status RunStart(const Drive& drive, const std::shared_ptr<const floam::LocalisationMap>& map,
                      const Pose& T_world_map, bool same_ground, LocalisationStart* start,
                      Sums* sums) {
  const auto sensor = floam::FindSensorModel(drive.sensor);
  if (!sensor.ok()) return sensor.status();
  floam::Localiser localiser(*sensor, floam::OdometryOptions());
  localiser.SetMap(map);
  const int64_t begin_ns = drive.shots[start->turn].end_stamp_ns;
  const size_t end = drive.shots.size();
  for (size_t i = start->turn; i < end; ++i) {
    const Shot& shot = drive.shots[i];
    const double passed_s = 1e-9 * static_cast<double>(shot.end_stamp_ns - begin_ns);
    if (passed_s > kStartS) break;
    const Stopwatch watch;
    const auto result = localiser.Process(MakeScan(drive, shot, i + 1));
    if (!result.ok()) continue;
    ++start->scans;
    if (start->first_s < 0)
      start->first_cpu_s += 1e-3 * (result->odometry.timing.total_ms + result->localising_ms);
    start->was_ambiguous |= result->status == floam::LocalisationStatus::kAmbiguous;
    if (!result->has_pose()) continue;
    const Pose error = (T_world_map * result->T_map_sensor).Inverse() * drive.truth_of(shot.turn);
    const double error_m = same_ground ? error.translation().norm() : 1e3;
    if (start->first_s < 0) {
      start->first_s = passed_s;
      start->first_error_m = error_m;
    } else {
      sums->odometry_ms += result->odometry.timing.total_ms;
      sums->localising_ms += result->localising_ms;
      ++sums->followed;
    }
    if (result->status != floam::LocalisationStatus::kLocated) {
      ++start->uncertain;
      continue;
    }
    ++start->located;
    start->wrong += error_m > drive.wrong_m;
    start->errors_m.push_back(error_m);
  }
  return absl::OkStatus();
}

double NearestM(const DrivenRobot& map, const Pose& T_world_sensor) {
  double nearest = 1e9;
  for (const ScanPose& pose : map.poses) {
    const Eigen::Vector3d way = pose.T_world_sensor.translation() - T_world_sensor.translation();
    nearest = std::min(nearest, way.norm());
  }
  return nearest;
}

double Rmse(const std::vector<double>& errors) {
  double sum = 0;
  for (const double error : errors) sum += error * error;
  return errors.empty() ? 0 : std::sqrt(sum / static_cast<double>(errors.size()));
}

double Worst(const std::vector<double>& errors) {
  return errors.empty() ? 0 : *std::max_element(errors.begin(), errors.end());
}

}  // namespace

absl::StatusOr<LocalisationTrial> RunLocalisation(const DrivenRobot& map, const Drive& drive,
                                                  int starts, bool same_ground) {
  const auto aligned = evaluation::CompareTrajectories({WayOf(map)});
  if (!aligned.ok()) return aligned.status();
  LocalisationTrial trial;
  const Stopwatch watch;
  auto built = std::make_shared<floam::LocalisationMap>();
  for (const auto& submap : map.submaps) built->Add(*submap, submap->T_odom_submap);
  trial.map_s = 1e-3 * watch.Ms();
  trial.map_voxels = built->memory()->voxel_count();
  if (drive.record) drive.record();
  Sums sums;
  for (int k = 0; k < starts; ++k) {
    LocalisationStart start;
    start.turn = static_cast<int>(drive.shots.size() * k / starts);
    start.nearest_m = NearestM(map, drive.truth_of(drive.shots[start.turn].turn));
    absl::Status status =
        RunStart(drive, built, aligned->T_truth_estimate, same_ground, &start, &sums);
    if (!status.ok()) return status;
    trial.starts.push_back(std::move(start));
  }
  if (sums.followed > 0) {
    trial.odometry_ms = sums.odometry_ms / sums.followed;
    trial.localising_ms = sums.localising_ms / sums.followed;
  }
  return trial;
}

std::string ToText(const LocalisationTrial& trial) {
  std::string text = absl::StrFormat(
      "%s: %d voxels in %.2f s; odometry %.1f ms + localising %.1f ms per scan\n", trial.name,
      trial.map_voxels, trial.map_s, trial.odometry_ms, trial.localising_ms);
  for (const LocalisationStart& start : trial.starts) {
    absl::StrAppendFormat(&text,
                          "  from %4d, %5.1f m off the map's way: first %5.1f s (cpu %.2f), %.3f m "
                          "off; located %3d, uncertain %3d of %3d; RMSE "
                          "%.3f, worst %.3f m, %d wrong%s\n",
                          start.turn, start.nearest_m, start.first_s, start.first_cpu_s,
                          start.first_error_m, start.located, start.uncertain, start.scans,
                          Rmse(start.errors_m), Worst(start.errors_m), start.wrong,
                          start.was_ambiguous ? "; ambiguous" : "");
  }
  return text;
}

std::string Summary(const std::vector<LocalisationTrial>& trials) {
  std::vector<double> errors, first_s;
  int starts = 0, found = 0, wrong_starts = 0, ambiguous = 0, near = 0, near_found = 0;
  for (const LocalisationTrial& trial : trials) {
    for (const LocalisationStart& start : trial.starts) {
      ++starts;
      ambiguous += start.was_ambiguous && start.first_s < 0;
      wrong_starts += start.wrong > 0;
      errors.insert(errors.end(), start.errors_m.begin(), start.errors_m.end());
      const bool is_near = start.nearest_m < kNearM;
      near += is_near;
      if (start.first_s < 0) continue;
      ++found;
      near_found += is_near;
      if (is_near) first_s.push_back(start.first_s);
    }
  }
  std::sort(first_s.begin(), first_s.end());
  return absl::StrFormat(
      "%d starts: %d found; of %d within %.0f m of the map's way %d (first pose after %.1f s, "
      "worst "
      "%.1f); %d with wrong poses, %d ambiguous to the end; RMSE %.3f m, worst %.3f m of %d "
      "located scans\n",
      starts, found, near, kNearM, near_found, first_s.empty() ? 0 : first_s[first_s.size() / 2],
      Worst(first_s), wrong_starts, ambiguous, Rmse(errors), Worst(errors), errors.size());
}

}  // namespace isthmus::bench
