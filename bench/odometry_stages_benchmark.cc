// The cost of each stage of the odometry, on simulated scans: a VLP-16 and an HDL-64, in a museum
// and in streets. Simulating, and whatever comes before the stage, is not measured.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/simulation/simulator.h"
#include "floam/map/local_map.h"
#include "floam/match/motion_model.h"
#include "floam/match/scan_matcher.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/rings/ring_scan.h"
#include "floam/scan/features.h"
#include "floam/scan/undistort.h"

namespace isthmus::floam {
namespace {

constexpr int kScans = 120;    // Of a drive from rest; ...
constexpr int kMapScans = 99;  // ... those before the last 20 make the map.
const std::pair<const char*, const char*> kSettings[] = {
    {"vlp16", "museum"}, {"vlp16", "campus"}, {"hdl64", "museum"}, {"hdl64", "campus"}};

template <typename T>
T OrDie(absl::StatusOr<T> value) {
  if (value.ok()) return *std::move(value);
  std::fprintf(stderr, "%s\n", value.status().ToString().c_str());
  std::exit(1);
}

void OrDie(const absl::Status& status) {
  if (!status.ok()) OrDie(absl::StatusOr<int>(status));
}

// A drive, and what the stages have made of it when its last scans come. Odom is the world frame.
struct Setting {
  OdometryOptions options;
  SensorModel sensor;
  std::vector<Scan> scans;
  std::vector<ScanPose> truth;
  LocalMap surfaces{ShapeKind::kPlane, options.map}, edges{ShapeKind::kLine, options.map};
  RingScan rings;  // Of the first scan after those in the map.
  Features features;

  Setting(const std::string& sensor_name, const std::string& world);

  const Scan& scan() const { return scans[kMapScans]; }
  double period_s() const { return sensor.scan_period_s; }
  ScanMotion MotionOf(const ScanPose& pose) const {
    return ScanMotion(pose.twist, pose.reference_s, -period_s(), 0);
  }
  std::vector<Eigen::Vector3d> InOdom(const std::vector<TimedPoint>& points,
                                      const ScanPose& pose) const;
};

Setting::Setting(const std::string& sensor_name, const std::string& world)
    : sensor(OrDie(FindSensorModel(sensor_name))) {
  simulation::Options simulated;
  simulated.world = world;
  simulated.sensor = sensor_name;
  simulated.seconds = 60;
  const auto simulator = OrDie(simulation::Simulator::Create(simulated));
  RingSorter sorter;
  FeatureExtractor extractor(options.features);
  for (int i = 0; i < kScans; ++i) {
    scans.push_back(simulator->MakeScan(0, i));
    const double begin = i * period_s();
    const Pose from = simulator->PoseAt(0, begin), to = simulator->PoseAt(0, begin + period_s());
    truth.push_back({simulator->PoseAt(0, begin + period_s() / 2),
                     Log(from.Inverse() * to) / period_s(), -period_s() / 2});
    if (i > kMapScans) continue;
    OrDie(sorter.Sort(scans[i], sensor, period_s(), &rings));
    extractor.Extract(rings, &features);
    if (i == kMapScans) continue;
    for (const auto& p : InOdom(features.map_surfaces, truth[i])) surfaces.Insert(p);
    for (const auto& p : InOdom(features.edges, truth[i])) edges.Insert(p);
  }
}

std::vector<Eigen::Vector3d> Setting::InOdom(const std::vector<TimedPoint>& points,
                                             const ScanPose& pose) const {
  const ScanMotion motion = MotionOf(pose);
  std::vector<Eigen::Vector3d> moved;
  for (const TimedPoint& p : points) {
    moved.push_back(pose.T_odom_sensor * motion.ToReference(p.position, p.time).cast<double>());
  }
  return moved;
}

// Made when it is first asked for, and kept.
Setting& SettingOf(benchmark::State* state) {
  static std::map<int64_t, std::unique_ptr<Setting>> made;
  const auto& [sensor, world] = kSettings[state->range(0)];
  auto& setting = made[state->range(0)];
  if (setting == nullptr) setting = std::make_unique<Setting>(sensor, world);
  state->SetLabel(std::string(sensor) + " " + world);
  return *setting;
}

void SortRings(benchmark::State& state, bool fields) {
  const Setting& setting = SettingOf(&state);
  Scan scan = setting.scan();
  scan.has_ring = scan.has_time = fields;
  if (!fields) {
    for (ScanPoint& p : scan.points) p.ring = 0, p.time = 0;
  }
  RingSorter sorter;
  RingScan rings;
  for (auto _ : state) OrDie(sorter.Sort(scan, setting.sensor, setting.period_s(), &rings));
  state.counters["points"] = static_cast<double>(rings.points.size());
}
void BM_SortRings(benchmark::State& state) { SortRings(state, true); }
// Without fields for ring and time.
void BM_SortRingsInferred(benchmark::State& state) { SortRings(state, false); }

void BM_ExtractFeatures(benchmark::State& state) {
  const Setting& setting = SettingOf(&state);
  FeatureExtractor extractor(setting.options.features);
  Features features;
  for (auto _ : state) extractor.Extract(setting.rings, &features);
  state.counters["surfaces"] = static_cast<double>(features.surfaces.size());
  state.counters["edges"] = static_cast<double>(features.edges.size());
}

// A scan's points, where there are such already.
void BM_InsertIntoMap(benchmark::State& state) {
  const Setting& setting = SettingOf(&state);
  const auto points = setting.InOdom(setting.features.map_surfaces, setting.truth[kMapScans]);
  LocalMap map(ShapeKind::kPlane, setting.options.map);
  for (const auto& p : points) map.Insert(p);
  for (auto _ : state) {
    for (const auto& p : points) map.Insert(p);
  }
  state.counters["points"] = static_cast<double>(points.size());
}

// The shapes that a scan's features lie on, none of them looked up before.
void BM_FindInMap(benchmark::State& state) {
  Setting& setting = SettingOf(&state);
  const auto points = setting.InOdom(setting.features.surfaces, setting.truth[kMapScans]);
  double found_count = 0;
  for (auto _ : state) {
    found_count = 0;
    for (const auto& p : points) {
      LocalMap::Found found;
      setting.surfaces.Find(p, &found);
      found_count += found.shape != nullptr;
    }
  }
  state.counters["features"] = static_cast<double>(points.size());
  state.counters["found"] = found_count;
}

// One call, with nothing out of reach.
void BM_EvictFromMap(benchmark::State& state) {
  Setting& setting = SettingOf(&state);
  const Eigen::Vector3d robot = setting.truth[kMapScans].T_odom_sensor.translation();
  for (auto _ : state) setting.surfaces.Evict(robot);
  state.counters["blocks"] = static_cast<double>(setting.surfaces.block_count());
}

// From where the motion of the scan before leads, as in kContinuous.
void BM_Match(benchmark::State& state) {
  Setting& setting = SettingOf(&state);
  const ScanPose& before = setting.truth[kMapScans - 1];
  ScanPose guess = before;
  guess.T_odom_sensor = before.At(before.reference_s + setting.period_s());
  TwistPrior prior;
  prior.T_odom_previous = before.T_odom_sensor;
  prior.since_previous_s = setting.period_s();
  prior.sigma.setConstant(setting.options.speed_change_sigma);
  const PosePrior expected{guess.T_odom_sensor, MotionModel().Displacement(setting.period_s())};
  ScanMatcher matcher;
  MatchResult match;
  for (auto _ : state) {
    match = matcher.Match(setting.features, guess, expected, prior, setting.options.matching,
                          &setting.surfaces, &setting.edges);
  }
  const Pose error = setting.truth[kMapScans].T_odom_sensor.Inverse() * match.pose.T_odom_sensor;
  state.counters["iterations"] = match.iterations;
  state.counters["used"] = match.used;
  state.counters["error_mm"] = 1e3 * error.translation().norm();
}

void BM_Undistort(benchmark::State& state) {
  const Setting& setting = SettingOf(&state);
  const ScanPose& pose = setting.truth[kMapScans];
  Cloud cloud;
  for (auto _ : state) {
    Undistort(setting.rings, ScanMotion(pose.twist, 0, -setting.period_s(), 0), &cloud);
  }
  state.counters["points"] = static_cast<double>(cloud.size());
}

// Whole scans, one after the other, the start of the drive not counted.
void BM_Process(benchmark::State& state) {
  const Setting& setting = SettingOf(&state);
  constexpr size_t kUnderWay = 20;
  std::optional<Odometry> odometry;
  size_t next = kScans;
  for (auto _ : state) {
    if (next == kScans) {
      state.PauseTiming();
      odometry.emplace(setting.sensor, setting.options);
      for (next = 0; next < kUnderWay; ++next) OrDie(odometry->Process(setting.scans[next]));
      state.ResumeTiming();
    }
    benchmark::DoNotOptimize(odometry->Process(setting.scans[next++]));
  }
}

void EverySetting(benchmark::internal::Benchmark* benchmark) {
  benchmark->DenseRange(0, std::size(kSettings) - 1)->Unit(benchmark::kMicrosecond);
}

BENCHMARK(BM_SortRings)->Apply(EverySetting);
BENCHMARK(BM_SortRingsInferred)->Apply(EverySetting);
BENCHMARK(BM_ExtractFeatures)->Apply(EverySetting);
BENCHMARK(BM_InsertIntoMap)->Apply(EverySetting);
BENCHMARK(BM_FindInMap)->Apply(EverySetting);
BENCHMARK(BM_EvictFromMap)->Apply(EverySetting);
BENCHMARK(BM_Match)->Apply(EverySetting);
BENCHMARK(BM_Undistort)->Apply(EverySetting);
BENCHMARK(BM_Process)->Apply(EverySetting);

}  // namespace
}  // namespace isthmus::floam
