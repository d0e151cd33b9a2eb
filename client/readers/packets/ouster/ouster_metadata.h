// The metadata of an Ouster sensor: what its packets hold and where its beams point.
#pragma once

#include <absl/status/statusor.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace isthmus::readers::ouster {

// UDP profiles of the LiDAR data, Ouster Firmware User Manual, "LiDAR Data Packet Format".
enum class Profile : uint8_t { kLegacy, kSingle, kDual, kLowRate };

// The name of the profile in the metadata.
const char* NameOf(Profile profile);

// Row major; metres.
using Transform = std::array<double, 16>;

struct Metadata {
  Profile profile = Profile::kLegacy;
  int columns_per_frame = 0, columns_per_packet = 0, pixels_per_column = 0;
  // Degrees, of each row from the uppermost down.
  std::vector<double> beam_altitudes, beam_azimuths;
  // From the axis of the LiDAR to where beams begin, in the plane of a beam: forward and up.
  double beam_forward_m = 0, beam_up_m = 0;
  Transform lidar_to_sensor = {};
  std::string product;  // "OS-1-32-G"; empty if it does not say.
  // Numbers of the unit, and of its start; 0 if it does not say.
  uint64_t serial = 0;
  uint32_t start = 0;
};

// Reads JSON of firmware 2.0 and later: flat, or nested in sensor_info, beam_intrinsics,
// lidar_intrinsics and lidar_data_format. InvalidArgument, naming it, for what is missing, does not
// fit or is out of range, and for a profile that is not known.
absl::StatusOr<Metadata> ParseMetadata(const std::string& json);

}  // namespace isthmus::readers::ouster
