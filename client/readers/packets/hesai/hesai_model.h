// The models of Hesai sensors: where their lasers point and when they fire.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <optional>
#include <string>

#include "client/readers/packets/laser_geometry.h"

namespace isthmus::readers::hesai {

// The Pandar128 sends as the OT128 does.
enum class Model : uint8_t {
  kPandar40P,
  kPandar64,
  kPandarQt64,
  kPandarXt16,
  kPandarXt32,
  kPandarXt32M,
  kPandarQt128,
  kOt128,
};

const char* NameOf(Model model);  // "Pandar40P"
int Lasers(Model model);

// By the name of a sensor, in any of its usual spellings. InvalidArgument for any other.
absl::StatusOr<Model> ModelOfName(absl::string_view name);

// The nominal angles of the maker's manual; empty for those whose units differ too much.
std::optional<Calibration> NominalCalibration(Model model);

// The pattern in which a sensor fires, as its packets say.
struct FiringState {
  int returns = 1;          // Blocks that share an azimuth, from 1 to 3.
  bool high_res = false;    // OT128.
  int azimuth_state = 0;    // OT128: from 0 to 3, of the block.
  bool first_loop = false;  // QT128 with more returns than one.
};

// Nanoseconds from the time of a packet to the firing of a laser of a block; the manuals' sections
// on the absolute time of points.
int64_t FiringTimeNs(Model model, const FiringState& state, int block, int laser);

}  // namespace isthmus::readers::hesai
