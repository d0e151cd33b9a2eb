// The scans that robots of the load generator send, encoded beforehand.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/point_payload.h"

namespace isthmus::loadgen {

// The scans of one robot in the sensor frame, as they travel.
struct Drive {
  struct OneScan {
    int64_t end_stamp_ns = 0;
    PointPayload payload;
  };
  std::string sensor;
  std::vector<OneScan> scans;
};

using Drives = std::vector<std::shared_ptr<const Drive>>;

struct SimulatedDrives {
  std::string world = "museum";
  std::string sensor = "vlp16";
  int drives = 1;
  double seconds = 60;
  uint64_t seed = 1;
};

// Simulates them, by as many threads as there are cores. InvalidArgument for a world or a sensor
// that does not exist.
absl::StatusOr<Drives> SimulateDrives(const SimulatedDrives& options);

// One scan of so many points, of a room of 20 by 30 m, without rings and times.
Drives MakeDenseDrive(int points);

// Reads recordings, whatever they were recorded in, the first `seconds` of each. What is assumed of
// them goes to stderr. NotFound or InvalidArgument for what is none.
absl::StatusOr<Drives> ReadDrives(const std::vector<std::string>& recordings, double seconds);

}  // namespace isthmus::loadgen
