#include "client/simulation/sensors/lidar.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <Eigen/Geometry>

#include "client/simulation/sensors/scan_patterns.h"

namespace isthmus::simulation {
namespace {

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
