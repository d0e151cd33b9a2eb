// The models of Velodyne sensors: where their lasers point and when they fire.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "client/readers/packets/velodyne/velodyne_packet.h"

namespace isthmus::readers::velodyne {

// A laser's place and corrections, metres and radians. The terms are those of the calibration of
// the HDL-64E S2 (User's Manual, appendix on two point calibration), which the others leave 0.
struct Laser {
  double elevation = 0;
  double rotation = 0;  // Points at azimuth minus this.
  double vertical_offset = 0, horizontal_offset = 0;
  // Added to z alone, after all else: the vertical correction of the VLP-16 User Manual, table 9-1.
  double height = 0;
  // Added to the range: far away, and in x and y (of the manual) near the sensor.
  double range_far = 0, range_near_x = 0, range_near_y = 0;
  bool two_point = false;
  double focal_distance = 0, focal_slope = 0;  // Of the intensity; distance in centimetres.
  double min_intensity = 0, max_intensity = 255;
};

struct Calibration {
  std::vector<Laser> lasers;  // By number.
  double range_unit_m = 0.002;
  std::string source;  // "the tables of the VLP-16 User Manual"
};

enum class Model : uint8_t { kVlp16, kPuckHiRes, kVlp32, kHdl32, kHdl64 };

// As sensor_model.h names them.
const char* SensorName(Model model);
int Lasers(Model model);

// By the name of a sensor, in any of its usual spellings. InvalidArgument for any other.
absl::StatusOr<Model> ModelOfName(absl::string_view name);
// By the product that sent a packet; empty if that is not known.
std::optional<Model> ModelOf(const Packet& packet);

// The tables of the manual; empty for the HDL-64E, of which each unit has its own.
std::optional<Calibration> ManualCalibration(Model model);

// When each measurement of a packet was made, microseconds after the packet's time (before it:
// negative), by block and laser.
using FiringTimes = std::array<std::array<double, kLasersPerBlock>, kBlocks>;
FiringTimes TimesOf(Model model, bool dual);

// Blocks from one azimuth to the next: of the returns and banks that were fired at once.
int BlocksPerFiring(Model model, bool dual);

}  // namespace isthmus::readers::velodyne
