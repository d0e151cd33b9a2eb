#include "floam/rings/sensor_model.h"

#include <absl/status/status.h>
#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <cstring>
#include <numbers>
#include <utility>

#include "core/geometry/angles.h"
#include "core/vlp32_angles.h"

namespace isthmus::floam {
namespace {

std::vector<double> Uniform(double lowest_deg, double highest_deg, int rings) {
  std::vector<double> elevations;
  for (int ring = 0; ring < rings; ++ring) {
    const double fraction = static_cast<double>(ring) / (rings - 1);
    elevations.push_back((lowest_deg + fraction * (highest_deg - lowest_deg)) * kRadPerDeg);
  }
  return elevations;
}

std::vector<double> Degrees(std::vector<double> elevations) {
  for (double& elevation : elevations) elevation *= kRadPerDeg;
  return elevations;
}

std::vector<double> Vlp32Elevations() {
  std::vector<double> elevations(kVlp32Elevations.begin(), kVlp32Elevations.end());
  std::sort(elevations.begin(), elevations.end());
  return Degrees(std::move(elevations));
}

// Two blocks of 32 lasers, half a degree and a third of a degree apart (HDL-64E user manual).
std::vector<double> Hdl64Elevations() {
  std::vector<double> elevations = Uniform(-24.33, -8.83, 32);
  const std::vector<double> upper = Uniform(-8.33, 2.0, 32);
  elevations.insert(elevations.end(), upper.begin(), upper.end());
  return elevations;
}

SensorModel Velodyne(std::string name, std::vector<double> elevations, double max_range_m) {
  SensorModel model;
  model.name = std::move(name);
  model.rings = static_cast<int>(elevations.size());
  model.elevations = std::move(elevations);
  model.max_range_m = max_range_m;
  model.start_azimuth = std::numbers::pi;  // Cut at the rear, as the KITTI recordings are.
  return model;
}

SensorModel Ouster(const std::string& family, int rings, double half_view_deg, double max_range_m) {
  SensorModel model;
  model.name = absl::StrCat(family, "-", rings);
  model.rings = rings;
  model.elevations = Uniform(-half_view_deg, half_view_deg, rings);
  model.max_range_m = max_range_m;
  model.start_azimuth = std::numbers::pi;  // Encoder zero is at the connector, at the rear.
  return model;
}

SensorModel Spinning() {
  SensorModel model;
  model.name = "spinning";
  model.max_range_m = 200;
  model.start_azimuth = std::numbers::pi;
  return model;
}

// A sensor of which nothing more is known, or need be.
SensorModel Rings(const char* name, int rings, double max_range_m) {
  SensorModel model = Spinning();
  model.name = name;
  model.rings = rings;
  model.max_range_m = max_range_m;
  return model;
}

SensorModel Unordered(const char* name, double max_range_m) {
  SensorModel model;
  model.name = name;
  model.spins = false;
  model.max_range_m = max_range_m;
  return model;
}

std::vector<SensorModel> KnownModels() {
  std::vector<SensorModel> models = {
      Velodyne("vlp16", Uniform(-15, 15, 16), 100),
      Velodyne("vlp32", Vlp32Elevations(), 200),
      Velodyne("hdl32", Uniform(-30.67, 10.67, 32), 100),
      Velodyne("hdl64", Hdl64Elevations(), 120),
  };
  models.back().sorted_files = true;
  for (const int rings : {32, 64, 128}) {
    models.push_back(Ouster("os0", rings, 45.0, 50));
    models.push_back(Ouster("os1", rings, 22.5, 120));
    models.push_back(Ouster("os2", rings, 11.25, 240));
  }
  models.push_back(Rings("vls128", 128, 220));
  models.push_back(Rings("m8", 8, 150));
  models.push_back(Spinning());
  models.push_back(Unordered("solid", 200));
  models.push_back(Unordered("mid360", 70));
  for (const char* livox : {"mid40", "mid70", "avia", "horizon", "tele15"}) {
    models.push_back(Unordered(livox, 260));
  }
  models.push_back(Unordered("unordered", 200));
  return models;
}

// "Velodyne VLP-32C" and "vlp32" become "vlp32".
std::string Normalised(const std::string& name) {
  std::string letters;
  for (const char c : absl::AsciiStrToLower(name)) {
    if (absl::ascii_isalnum(c)) letters += c;
  }
  if (letters == "any" || letters == "livox") return "unordered";
  if (letters == "solidstate") return "solid";
  for (const char* maker : {"velodyne", "ouster", "quanergy", "livox"}) {
    if (absl::StartsWith(letters, maker)) letters.erase(0, std::strlen(maker));
  }
  if (letters == "auto" || letters == "unknown") return "spinning";
  const bool generation = letters.size() > 1 && absl::ascii_isdigit(letters[letters.size() - 2]) &&
                          absl::ascii_isalpha(letters.back());
  if (generation) letters.pop_back();
  return letters;
}

}  // namespace

absl::StatusOr<SensorModel> FindSensorModel(const std::string& name) {
  const std::string wanted = Normalised(name);
  for (SensorModel& model : KnownModels()) {
    if (Normalised(model.name) == wanted) return std::move(model);
  }
  return absl::NotFoundError(absl::StrCat(
      "unknown sensor model \"", name, "\"; known are ", absl::StrJoin(SensorModelNames(), ", "),
      "; \"spinning\" takes any LiDAR that spins, \"unordered\" any other"));
}

std::vector<std::string> SensorModelNames() {
  std::vector<std::string> names;
  for (const SensorModel& model : KnownModels()) names.push_back(model.name);
  return names;
}

}  // namespace isthmus::floam
