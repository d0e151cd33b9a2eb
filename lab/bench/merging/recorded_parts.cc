#include "lab/bench/merging/recorded_parts.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "floam/rings/ring_scan.h"
#include "floam/rings/sensor_model.h"

namespace isthmus::bench {
namespace {

double MeanHeight(const floam::RingScan& sorted, size_t ring) {
  double sum = 0;
  const uint32_t begin = sorted.ring_begin[ring], end = sorted.ring_begin[ring + 1];
  for (uint32_t i = begin; i < end; ++i) sum += sorted.points[i].z / sorted.points[i].range;
  return begin == end ? 0 : sum / (end - begin);
}

Scan Mirrored(const Scan& scan, const floam::RingScan& sorted) {
  Scan mirrored;
  mirrored.sequence = scan.sequence;
  mirrored.end_stamp_ns = scan.end_stamp_ns;
  mirrored.has_ring = mirrored.has_time = true;
  const size_t rings = sorted.ring_begin.size() - 1;
  const bool upwards = MeanHeight(sorted, 0) < MeanHeight(sorted, rings - 1);
  for (size_t ring = 0; ring < rings; ++ring) {
    for (uint32_t i = sorted.ring_begin[ring]; i < sorted.ring_begin[ring + 1]; ++i) {
      const floam::RingPoint& p = sorted.points[i];
      const auto time = static_cast<float>(-sorted.period_s - p.time);
      const auto index = static_cast<uint16_t>(upwards ? ring : rings - 1 - ring);
      mirrored.points.push_back({p.x, p.y, p.z, p.intensity, std::min(0.0f, time), index});
    }
  }
  std::stable_sort(mirrored.points.begin(), mirrored.points.end(),
                   [](const ScanPoint& a, const ScanPoint& b) { return a.time < b.time; });
  return mirrored;
}

}  // namespace

Drive PartOf(const Drive& drive, int from, int to) {
  Drive part = drive;
  const auto end = std::min<std::ptrdiff_t>(to + 1, std::ssize(drive.shots));
  part.shots.assign(drive.shots.begin() + std::min<std::ptrdiff_t>(from, end),
                    drive.shots.begin() + end);
  return part;
}

absl::StatusOr<Drive> Backwards(const Drive& drive) {
  const auto model = floam::FindSensorModel(drive.sensor);
  if (!model.ok()) return model.status();
  auto scans = std::make_shared<std::vector<Scan>>();
  floam::RingSorter sorter;
  floam::RingScan sorted;
  for (const Shot& shot : drive.shots) {
    const Scan scan = MakeScan(drive, shot, 1);
    absl::Status status = sorter.Sort(scan, *model, 0.1, &sorted);
    if (!status.ok()) return status;
    scans->push_back(Mirrored(scan, sorted));
  }
  Drive backwards = drive;
  const int count = static_cast<int>(drive.shots.size());
  const int64_t both_ends = drive.shots.front().end_stamp_ns + drive.shots.back().end_stamp_ns;
  for (int i = 0; i < count; ++i) {
    const int turn = count - 1 - i;
    backwards.shots[i] = {turn, both_ends - drive.shots[turn].end_stamp_ns};
  }
  backwards.scan_of = [scans](int turn) { return (*scans)[turn]; };
  // A turn begins where the one before ended.
  backwards.truth_of = [truth_of = drive.truth_of, first = drive.shots.front().turn](int turn) {
    return truth_of(std::max(0, first + turn - 1));
  };
  return backwards;
}

}  // namespace isthmus::bench
