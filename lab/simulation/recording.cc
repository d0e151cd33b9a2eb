#include "lab/simulation/recording.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <system_error>
#include <unordered_set>

#include "core/codec/payload_builder.h"
#include "core/formats/pcd.h"
#include "core/formats/tum.h"
#include "core/io/file_io.h"
#include "core/pose.h"
#include "core/scan.h"

namespace isthmus::simulation {
namespace {

// The surface a robot has measured, as cubic cells of the world. Not thread safe.
class SeenSurface {
 public:
  explicit SeenSurface(double cell_m) : cell_m_(cell_m) {}

  void Add(const Scan& scan, const Pose& T_world_sensor);
  size_t cells() const { return cells_.size(); }

  // Both must have the same size of cells. Share of the cells of the one with fewer of them that
  // the other has too, [0, 1].
  static double Overlap(const SeenSurface& a, const SeenSurface& b);

 private:
  double cell_m_;
  std::unordered_set<uint64_t> cells_;
};

void SeenSurface::Add(const Scan& scan, const Pose& T_world_sensor) {
  constexpr size_t kEvery = 8;  // Surfaces are seen many times: some of the points will do.
  const Eigen::Matrix3d rotation = T_world_sensor.RotationMatrix();
  for (size_t i = 0; i < scan.points.size(); i += kEvery) {
    const ScanPoint& p = scan.points[i];
    const Eigen::Vector3d at =
        rotation * Eigen::Vector3d(p.x, p.y, p.z) + T_world_sensor.translation();
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<int64_t>(std::floor(at[axis] / cell_m_));
      key = (key << 21) | (static_cast<uint64_t>(cell) & 0x1FFFFF);
    }
    cells_.insert(key);
  }
}

double SeenSurface::Overlap(const SeenSurface& a, const SeenSurface& b) {
  const bool a_is_smaller = a.cells() < b.cells();
  const SeenSurface &small = a_is_smaller ? a : b, &large = a_is_smaller ? b : a;
  if (small.cells_.empty()) return 0;
  const auto common = std::count_if(small.cells_.begin(), small.cells_.end(),
                                    [&](uint64_t cell) { return large.cells_.contains(cell); });
  return static_cast<double>(common) / static_cast<double>(small.cells());
}

absl::Status MakeFolder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!error) return absl::OkStatus();
  return absl::PermissionDeniedError(absl::StrCat("cannot make the folder ", path, ": ",
                                                  error.message(),
                                                  "; choose another with the output option"));
}

absl::Status RecordScan(const Simulator& simulator, int robot, int index, const std::string& dir,
                        SeenSurface& seen) {
  const Scan scan = simulator.MakeScan(robot, index);
  const int turns_per_second = static_cast<int>(1 / simulator.lidar().period_s);
  if (index % turns_per_second == 0) seen.Add(scan, simulator.Truth(robot, index).pose);
  return formats::WritePcd(absl::StrFormat("%s/%06d.pcd", dir, index), codec::MakePayload(scan),
                           formats::PcdEncoding::kBinary);
}

absl::Status WriteStamps(const Simulator& simulator, int robot, const std::string& name) {
  Trajectory truth = simulator.Truth(robot);
  std::string times;
  for (size_t i = 0; i < truth.size(); ++i) {
    truth[i].stamp_ns = simulator.Stamp(robot, static_cast<int>(i));  // The scan is known by it.
  }
  for (const StampedPose& entry : truth) {
    absl::StrAppendFormat(&times, "%d.%09d\n", entry.stamp_ns / 1'000'000'000,
                          entry.stamp_ns % 1'000'000'000);
  }
  if (auto status = io::WriteFile(name + "/times.txt", times); !status.ok()) return status;
  return formats::WriteTum(name + ".truth.tum", truth);
}

// The volumes that came and went, as boxes along the axes of the world.
std::string TruthOfMoved(const Simulator& simulator) {
  std::vector<std::string> rows;
  for (const MovedVolume& volume : simulator.moved()) {
    const Eigen::Vector3d &min = volume.bounds.min(), &max = volume.bounds.max();
    rows.push_back(absl::StrFormat(
        "  {\"kind\": \"%s\", \"min\": [%.3f, %.3f, %.3f], \"max\": [%.3f, %.3f, %.3f]}",
        volume.came ? "came" : "went", min.x(), min.y(), min.z(), max.x(), max.y(), max.z()));
  }
  return absl::StrCat("[\n", absl::StrJoin(rows, ",\n"), "\n]\n");
}

std::string ToJson(const Simulator& simulator, const RecordingSummary& summary) {
  const Options& options = simulator.options();
  std::vector<std::string> rows;
  for (const auto& row : summary.overlap) {
    const auto number = [](std::string* out, double x) { absl::StrAppendFormat(out, "%.3f", x); };
    rows.push_back(absl::StrCat("[", absl::StrJoin(row, ", ", number), "]"));
  }
  return absl::StrFormat(
      "{\n"
      "  \"world\": \"%s\",\n  \"sensor\": \"%s\",\n  \"seed\": %d,\n  \"robots\": %d,\n"
      "  \"walkers\": %d,\n  \"cars\": %d,\n  \"parked\": %d,\n  \"day\": %d,\n  \"moved\": %d,\n"
      "  \"seconds\": %g,\n  \"scans_per_robot\": %d,\n  \"range_sigma_m\": %g,\n"
      "  \"overlap\": [%s]\n}\n",
      options.world, simulator.lidar().name, options.seed, summary.robots, options.walkers,
      options.cars, options.parked, options.day, options.moved, options.seconds,
      summary.scans_per_robot, options.noise.range_sigma_m, absl::StrJoin(rows, ", "));
}

struct RecordedRobot {
  const Simulator* simulator;
  int robot;  // Its number there.
};

void AddRobots(const Simulator& simulator, std::vector<RecordedRobot>* robots) {
  for (int robot = 0; robot < simulator.robots(); ++robot) robots->push_back({&simulator, robot});
}

absl::StatusOr<RecordingSummary> RecordRobots(const std::vector<RecordedRobot>& robots,
                                              const std::string& dir, const Progress& progress) {
  const Simulator& first = *robots.front().simulator;
  RecordingSummary summary;
  summary.robots = static_cast<int>(robots.size());
  summary.scans_per_robot = first.scan_count();
  std::vector<SeenSurface> seen(robots.size(), SeenSurface(first.world().overlap_cell_m));
  int done = 0;
  for (size_t k = 0; k < robots.size(); ++k) {
    const auto& [simulator, robot] = robots[k];
    const std::string robot_dir = absl::StrCat(dir, "/robot_", k);
    if (auto status = MakeFolder(robot_dir); !status.ok()) return status;
    for (int i = 0; i < summary.scans_per_robot; ++i) {
      if (progress) progress(done++, summary.robots * summary.scans_per_robot);
      auto status = RecordScan(*simulator, robot, i, robot_dir, seen[k]);
      if (!status.ok()) return status;
    }
    if (auto status = WriteStamps(*simulator, robot, robot_dir); !status.ok()) return status;
  }
  for (const SeenSurface& a : seen) {
    auto& row = summary.overlap.emplace_back();
    for (const SeenSurface& b : seen) row.push_back(SeenSurface::Overlap(a, b));
  }
  if (first.options().day > 1) {
    auto truth = io::WriteFile(dir + "/moved.truth.json", TruthOfMoved(first));
    if (!truth.ok()) return truth;
  }
  auto status = io::WriteFile(dir + "/simulation.json", ToJson(first, summary));
  if (!status.ok()) return status;
  return summary;
}

}  // namespace

absl::StatusOr<RecordingSummary> Record(const Options& options, const std::string& dir,
                                        const Progress& progress) {
  const auto team = Simulator::CreateTeam(options);
  if (!team.ok()) return team.status();
  std::vector<RecordedRobot> robots;
  for (const auto& simulator : *team) AddRobots(*simulator, &robots);
  return RecordRobots(robots, dir, progress);
}

absl::StatusOr<RecordingSummary> Record(const Simulator& simulator, const std::string& dir,
                                        const Progress& progress) {
  std::vector<RecordedRobot> robots;
  AddRobots(simulator, &robots);
  return RecordRobots(robots, dir, progress);
}

}  // namespace isthmus::simulation
