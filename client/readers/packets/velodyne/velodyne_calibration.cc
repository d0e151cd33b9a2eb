#include "client/readers/packets/velodyne/velodyne_calibration.h"

#include <absl/strings/str_cat.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <vector>

#include "client/readers/packets/limits.h"

namespace isthmus::readers::velodyne {
namespace {

constexpr int kMostLasers = 128;  // Format

absl::Status BadCalibration(absl::string_view what) {
  return absl::InvalidArgumentError(absl::StrCat(
      "the calibration cannot be used: ", what,
      "; it must be the YAML of velodyne_pointcloud (num_lasers, distance_resolution, lasers)"));
}

// yaml-cpp throws where a value is no number.
double NumberOf(const YAML::Node& map, const char* key, double otherwise) {
  const YAML::Node node = map[key];
  if (!node.IsDefined() || node.IsNull()) return otherwise;
  const double value = node.as<double>();
  if (!std::isfinite(value) || std::abs(value) > 1e6) {
    throw YAML::Exception(node.Mark(), absl::StrCat(key, " is out of range"));
  }
  return value;
}

Laser ReadLaser(const YAML::Node& map) {
  Laser laser;
  laser.rotation = NumberOf(map, "rot_correction", 0);
  laser.elevation = NumberOf(map, "vert_correction", 0);
  laser.range_far = NumberOf(map, "dist_correction", 0);
  laser.range_near_x = NumberOf(map, "dist_correction_x", 0);
  laser.range_near_y = NumberOf(map, "dist_correction_y", 0);
  laser.two_point =
      map["dist_correction_x"].IsDefined() && map["dist_correction_y"].IsDefined() &&
      (laser.range_near_x != laser.range_far || laser.range_near_y != laser.range_far);
  laser.vertical_offset = NumberOf(map, "vert_offset_correction", 0);
  laser.horizontal_offset = NumberOf(map, "horiz_offset_correction", 0);
  laser.focal_distance = NumberOf(map, "focal_distance", 0);
  laser.focal_slope = NumberOf(map, "focal_slope", 0);
  laser.min_intensity = NumberOf(map, "min_intensity", 0);
  laser.max_intensity = NumberOf(map, "max_intensity", 255);
  return laser;
}

absl::StatusOr<Calibration> ReadLasers(const YAML::Node& root) {
  if (!root.IsMap() || !root["lasers"].IsDefined() || !root["lasers"].IsSequence()) {
    return BadCalibration("it has no list of lasers");
  }
  const YAML::Node lasers = root["lasers"];
  const size_t count = lasers.size();
  const double expected = NumberOf(root, "num_lasers", static_cast<double>(count));
  if (count == 0 || expected != static_cast<double>(count)) {
    return BadCalibration(absl::StrCat("num_lasers is ", expected, ", and there are ", count));
  }
  if (count > kMostLasers) {
    return BadCalibration(
        absl::StrCat("it has ", count, " lasers, and no sensor has more than ", kMostLasers));
  }
  Calibration calibration;
  calibration.source = "the calibration that was given";
  calibration.range_unit_m = NumberOf(root, "distance_resolution", calibration.range_unit_m);
  if (!(calibration.range_unit_m > 0) || calibration.range_unit_m > 1) {
    return BadCalibration("distance_resolution is no length of up to a metre");
  }
  calibration.lasers.resize(count);
  std::vector<bool> given(count);
  for (const YAML::Node& map : lasers) {
    if (!map.IsMap()) return BadCalibration("a laser is no map");
    const double id = NumberOf(map, "laser_id", -1);
    if (id < 0 || id >= static_cast<double>(count) || id != std::floor(id) ||
        given[static_cast<size_t>(id)]) {
      return BadCalibration(absl::StrCat("laser_id ", id, " is given twice or out of range"));
    }
    given[static_cast<size_t>(id)] = true;
    calibration.lasers[static_cast<size_t>(id)] = ReadLaser(map);
  }
  return calibration;
}

}  // namespace

absl::StatusOr<Calibration> ParseCalibration(const std::string& yaml) {
  if (yaml.size() > kMaxDescriptionBytes) return BadCalibration("it is too large");
  try {
    return ReadLasers(YAML::Load(yaml));
  } catch (const YAML::Exception& error) {
    return BadCalibration(error.what());
  }
}

absl::Status CheckCalibration(Model model, const std::optional<Calibration>& calibration) {
  if (!calibration) {
    return absl::InvalidArgumentError(
        "an HDL-64E needs the calibration of its unit, since each has its own: give the YAML that "
        "was made from the unit's db.xml (velodyne_pointcloud's gen_calibration.py makes it)");
  }
  if (calibration->lasers.size() == static_cast<size_t>(Lasers(model))) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat("the calibration has ", calibration->lasers.size(),
                                                 " lasers, and a ", SensorName(model), " has ",
                                                 Lasers(model), ": give that of the unit"));
}

}  // namespace isthmus::readers::velodyne
