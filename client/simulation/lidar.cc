#include "client/simulation/lidar.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <cmath>
#include <numbers>

namespace isthmus::simulation {
namespace {

// A laser in the order of firing.
struct Laser {
  uint16_t ring = 0;
  double elevation_deg = 0;
  double offset_s = 0;  // Since its group began.
};

// Rings 0, n/2, 1, n/2 + 1, ...: neighbours in time are far apart in elevation.
std::vector<Laser> Interleaved(int rings, double lowest_deg, double step_deg, double slot_s) {
  std::vector<Laser> lasers;
  for (int i = 0; i < rings; ++i) {
    const int ring = i / 2 + (i % 2) * rings / 2;
    lasers.push_back({static_cast<uint16_t>(ring), lowest_deg + ring * step_deg, i * slot_s});
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

Lidar Build(const std::string& name, const std::vector<Laser>& lasers, double group_s) {
  Lidar lidar;
  lidar.name = name;
  lidar.lasers = lasers.size();
  const auto groups = static_cast<int>(lidar.period_s / group_s + 1e-9);
  for (int group = 0; group < groups; ++group) {
    for (const Laser& laser : lasers) {
      Firing& firing = lidar.firings.emplace_back();
      firing.time_s = group * group_s + laser.offset_s;
      firing.ring = laser.ring;
      const double azimuth =
          std::numbers::pi * (1 - 2 * firing.time_s / lidar.period_s);  // Clockwise from the back.
      const double elevation = laser.elevation_deg * std::numbers::pi / 180;
      firing.direction =
          Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                          std::cos(elevation) * std::sin(azimuth), std::sin(elevation))
              .cast<float>();
    }
  }
  return lidar;
}

}  // namespace

std::vector<std::string> LidarNames() { return {"vlp16", "hdl32", "hdl64", "os1-64"}; }

absl::StatusOr<Lidar> MakeLidar(const std::string& name) {
  Lidar lidar;
  if (name == "vlp16") {
    lidar = Build(name, Interleaved(16, -15, 2, 2.304e-6), 55.296e-6);
  } else if (name == "hdl32") {
    lidar = Build(name, Interleaved(32, -30.67, 4.0 / 3, 1.152e-6), 46.08e-6);
  } else if (name == "hdl64") {
    lidar = Build(name, Hdl64(48e-6), 48e-6);
    lidar.max_range_m = 120;
  } else if (name == "os1-64") {
    lidar = Build(name, Interleaved(64, -22.5, 45.0 / 63, 0), 0.1 / 1024);
    lidar.max_range_m = 120;
  } else {
    return absl::InvalidArgumentError(absl::StrCat("no simulated sensor is called \"", name,
                                                   "\"; choose one of ",
                                                   absl::StrJoin(LidarNames(), ", ")));
  }
  return lidar;
}

}  // namespace isthmus::simulation
