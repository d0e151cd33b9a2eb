#include "lab/simulation/sensors/lidar.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/geometry/angles.h"
#include "core/vlp32_angles.h"

namespace isthmus::simulation {
namespace {

// A laser of a spinning sensor.
struct Laser {
  uint16_t ring = 0;
  double elevation_deg = 0;
  double offset_s = 0;  // Since its group began.
};

const double kGoldenAngle = std::numbers::pi * (3 - std::sqrt(5.0));
constexpr size_t kGroups = 1000;  // Sensors that do not spin: groups need only be short.

Eigen::Vector3f Direction(double azimuth, double elevation) {
  return Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                         std::cos(elevation) * std::sin(azimuth), std::sin(elevation))
      .cast<float>();
}

double Fraction(double x) { return x - std::floor(x); }

// `count` firings evenly in time; `direction` of the number of a firing.
template <typename Function>
void FireEvenly(size_t count, const Function& direction, Lidar* lidar) {
  lidar->has_rings = false;
  lidar->lasers = count / kGroups;
  for (size_t i = 0; i < count; ++i) {
    const double time_s = static_cast<double>(i) * lidar->period_s / static_cast<double>(count);
    lidar->firings.push_back({direction(static_cast<double>(i)), time_s, 0});
  }
}

// In the order of firing. Rings 0, n/2, 1, n/2 + 1, ...: neighbours in time are far apart in
// elevation.
std::vector<Laser> Interleaved(int rings, double lowest_deg, double step_deg, double slot_s) {
  std::vector<Laser> lasers;
  for (int i = 0; i < rings; ++i) {
    const int ring = i / 2 + (i % 2) * rings / 2;
    lasers.push_back({static_cast<uint16_t>(ring), lowest_deg + ring * step_deg, i * slot_s});
  }
  return lasers;
}

std::vector<Laser> Vlp32() {
  std::vector<Laser> lasers;
  for (size_t i = 0; i < kVlp32Elevations.size(); ++i) {
    const auto lower = std::count_if(kVlp32Elevations.begin(), kVlp32Elevations.end(),
                                     [&](double other) { return other < kVlp32Elevations[i]; });
    const double slot_s = 2.304e-6;
    const size_t slot = i / 2;  // Two lasers fire at a time.
    lasers.push_back(
        {static_cast<uint16_t>(lower), kVlp32Elevations[i], static_cast<double>(slot) * slot_s});
  }
  return lasers;
}

std::vector<Laser> Hdl64(double group_s) {
  std::vector<Laser> lasers;
  for (int i = 0; i < 64; ++i) {
    const double elevation = i < 32 ? -24.33 + i * 0.5 : -8.33 + (i - 32) / 3.0;
    lasers.push_back({static_cast<uint16_t>(i), elevation, i * group_s / 64});
  }
  return lasers;
}

// Quanergy's driver: 0.318505 rad below the horizon to 0.0557982 above it.
std::vector<Laser> M8(double slot_s) {
  constexpr std::array kElevations = {-0.318505, -0.2692,    -0.218009, -0.165195,
                                      -0.111003, -0.0557982, 0.0,       0.0557982};
  std::vector<Laser> lasers;
  for (size_t i = 0; i < kElevations.size(); ++i) {
    lasers.push_back(
        {static_cast<uint16_t>(i), kElevations[i] / kRadPerDeg, static_cast<double>(i) * slot_s});
  }
  return lasers;
}

// Each of these fills `firings`, `lasers`, `has_rings` and `turn_per_scan`.
void Spin(const std::vector<Laser>& lasers, double group_s, Lidar* lidar) {
  lidar->lasers = lasers.size();
  const auto groups = static_cast<int>(lidar->period_s / group_s + 1e-9);
  for (int group = 0; group < groups; ++group) {
    for (const Laser& laser : lasers) {
      Firing& firing = lidar->firings.emplace_back();
      firing.time_s = group * group_s + laser.offset_s;
      firing.ring = laser.ring;
      const double azimuth =
          std::numbers::pi * (1 - 2 * firing.time_s / lidar->period_s);  // Clockwise from the back.
      firing.direction = Direction(azimuth, laser.elevation_deg * std::numbers::pi / 180);
    }
  }
}

void ScanRaster(int columns, int rows, double width_deg, double height_deg, Lidar* lidar) {
  const auto direction = [&](double i) -> Eigen::Vector3f {
    const double row = std::floor(i / columns), column = i - row * columns;
    return Direction((0.5 - column / (columns - 1)) * width_deg * kRadPerDeg,
                     (0.5 - row / (rows - 1)) * height_deg * kRadPerDeg);
  };
  FireEvenly(static_cast<size_t>(columns) * rows, direction, lidar);
}

// The sequence R2 of M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences" (2018):
// any stretch of it is spread evenly.
void Scatter(int count, double lowest_deg, double highest_deg, Lidar* lidar) {
  constexpr double kPlastic = 1.32471795724474602596;
  const auto direction = [&](double i) -> Eigen::Vector3f {
    const double height = Fraction(0.5 + i / (kPlastic * kPlastic));
    return Direction(2 * std::numbers::pi * Fraction(i / kPlastic),
                     (lowest_deg + height * (highest_deg - lowest_deg)) * kRadPerDeg);
  };
  FireEvenly(count, direction, lidar);
  lidar->turn_per_scan = Eigen::Vector3d(0, 0, kGoldenAngle);
}

// Each prism turns the ray aside by a quarter of the width; they turn as fast as the Mid-40's, 7294
// and -4664 turns a minute.
void DrawRosette(int count, double width_deg, Lidar* lidar) {
  const double aside = width_deg * kRadPerDeg / 4;
  const auto direction = [&](double i) -> Eigen::Vector3f {
    const double time_s = i * lidar->period_s / count;
    const double a = 2 * std::numbers::pi * time_s * 7294 / 60,
                 b = -2 * std::numbers::pi * time_s * 4664 / 60;
    const Eigen::Vector2d off =
        aside * Eigen::Vector2d(std::cos(a) + std::cos(b), std::sin(a) + std::sin(b));
    const double angle = off.norm();
    const Eigen::Vector2d side = off / std::max(angle, 1e-12);
    return Eigen::Vector3d(std::cos(angle), std::sin(angle) * side.x(), std::sin(angle) * side.y())
        .cast<float>();
  };
  FireEvenly(count, direction, lidar);
  lidar->turn_per_scan = Eigen::Vector3d(kGoldenAngle, 0, 0);
}

struct Model {
  std::string name;
  double max_range_m;
  void (*fill)(Lidar* lidar);
};

template <int kRings, int kView>  // Tenths of a degree from the lowest to the highest.
void FillOuster(Lidar* lidar) {
  const double view_deg = kView / 10.0;
  Spin(Interleaved(kRings, -view_deg / 2, view_deg / (kRings - 1), 0), 0.1 / 1024, lidar);
}

const std::vector<Model>& Models() {
  static const auto* const models = new std::vector<Model>{
      {"vlp16", 100, [](Lidar* l) { Spin(Interleaved(16, -15, 2, 2.304e-6), 55.296e-6, l); }},
      {"vlp32", 200, [](Lidar* l) { Spin(Vlp32(), 55.296e-6, l); }},
      {"hdl32", 100,
       [](Lidar* l) { Spin(Interleaved(32, -30.67, 4.0 / 3, 1.152e-6), 46.08e-6, l); }},
      {"hdl64", 120, [](Lidar* l) { Spin(Hdl64(48e-6), 48e-6, l); }},
      {"vls128", 220,
       [](Lidar* l) { Spin(Interleaved(128, -25, 40.0 / 127, 53.3e-6 / 128), 53.3e-6, l); }},
      {"m8", 100, [](Lidar* l) { Spin(M8(6.25e-6), 50e-6, l); }},
      {"os0-32", 50, FillOuster<32, 900>},
      {"os0-64", 50, FillOuster<64, 900>},
      {"os0-128", 50, FillOuster<128, 900>},
      {"os1-32", 120, FillOuster<32, 450>},
      {"os1-64", 120, FillOuster<64, 450>},
      {"os1-128", 120, FillOuster<128, 450>},
      {"os2-32", 240, FillOuster<32, 225>},
      {"os2-64", 240, FillOuster<64, 225>},
      {"os2-128", 240, FillOuster<128, 225>},
      {"solid", 75, [](Lidar* l) { ScanRaster(240, 100, 120, 90, l); }},
      {"mid360", 70, [](Lidar* l) { Scatter(20000, -7, 52, l); }},
      {"mid70", 90, [](Lidar* l) { DrawRosette(10000, 70.4, l); }},
  };
  return *models;
}

}  // namespace

Eigen::Matrix3f TurnOfScan(const Lidar& lidar, int index) {
  const double turn = index * lidar.turn_per_scan.norm();
  if (turn == 0) return Eigen::Matrix3f::Identity();
  return Eigen::AngleAxisd(turn, lidar.turn_per_scan.normalized()).toRotationMatrix().cast<float>();
}

Lidar AtScan(Lidar lidar, int index) {
  if (lidar.turn_per_scan.isZero(0)) return lidar;
  const Eigen::Matrix3f turn = TurnOfScan(lidar, index);
  for (Firing& firing : lidar.firings) firing.direction = turn * firing.direction;
  return lidar;
}

std::vector<std::string> LidarNames() {
  std::vector<std::string> names;
  for (const Model& model : Models()) names.push_back(model.name);
  return names;
}

absl::StatusOr<Lidar> MakeLidar(const std::string& name) {
  for (const Model& model : Models()) {
    if (model.name != name) continue;
    Lidar lidar;
    lidar.name = name;
    lidar.max_range_m = model.max_range_m;
    model.fill(&lidar);
    return lidar;
  }
  return absl::InvalidArgumentError(absl::StrCat("no simulated sensor is called \"", name,
                                                 "\"; choose one of ",
                                                 absl::StrJoin(LidarNames(), ", ")));
}

}  // namespace isthmus::simulation
