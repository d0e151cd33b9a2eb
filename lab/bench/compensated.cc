#include "lab/bench/compensated.h"

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "core/geometry/angles.h"
#include "floam/rings/sensor_model.h"

namespace isthmus::bench {
namespace {

// Seconds before the END.
double TimeOf(const ScanPoint& p, const Scan& scan, const floam::SensorModel& model,
              double turn_s) {
  if (scan.has_time) return p.time;
  const double since = std::atan2(p.y, p.x) - model.start_azimuth;
  const double turns = (model.clockwise ? -since : since) / (2 * kPi);
  return (turns - std::floor(turns) - 1) * turn_s;
}

}  // namespace

absl::StatusOr<Drive> Compensated(const Drive& drive) {
  const auto model = floam::FindSensorModel(drive.sensor);
  if (!model.ok()) return model.status();
  std::map<int, int64_t> stamps_ns;  // By turn.
  for (const Shot& shot : drive.shots) stamps_ns.emplace(shot.turn, shot.end_stamp_ns);
  Drive compensated = drive;
  std::erase_if(compensated.shots, [](const Shot& shot) { return shot.turn == 0; });
  compensated.scan_of = [drive, model = *model, stamps_ns = std::move(stamps_ns)](int turn) {
    Scan scan = drive.scan_of(turn);
    double turn_s = model.scan_period_s;
    const auto before = stamps_ns.find(turn - 1), now = stamps_ns.find(turn);
    if (before != stamps_ns.end() && now != stamps_ns.end()) {
      turn_s = 1e-9 * static_cast<double>(now->second - before->second);
    }
    const Vector6d twist = Log(drive.truth_of(turn - 1).Inverse() * drive.truth_of(turn)) / turn_s;
    for (ScanPoint& p : scan.points) {
      const Pose T_end_then = Exp(TimeOf(p, scan, model, turn_s) * twist);
      const Eigen::Vector3f at = (T_end_then * Eigen::Vector3d(p.x, p.y, p.z)).cast<float>();
      p.x = at.x();
      p.y = at.y();
      p.z = at.z();
      p.time = 0;
    }
    scan.has_time = true;
    return scan;
  };
  return compensated;
}

}  // namespace isthmus::bench
