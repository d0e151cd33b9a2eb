// The models of Velodyne sensors: where their lasers point and when they fire.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <array>
#include <optional>

#include "client/readers/packets/laser_geometry.h"
#include "client/readers/packets/velodyne/velodyne_packet.h"

namespace isthmus::readers::velodyne {

enum class Model : uint8_t { kVlp16, kPuckHiRes, kVlp32, kHdl32, kHdl64, kVls128 };

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
// From the block of a first return to that of the second.
int BlocksToOtherReturn(Model model);

}  // namespace isthmus::readers::velodyne
